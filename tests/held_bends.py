"""Uniform bends that pressures hold on the ideal rod without gravity, in closed form, and how stiff they make its tip.

A bend b = (bx, by) has the curvature b/L, muscles of length L_i = L - r b.e_i, and needs the moment
EI b/L = r sum T_i e_i: T_i = T0 + 2 EI b.e_i/(3 r L), any T0. The pressures are P_i = T_i/f(L_i), f the McKibben force
of a pascal.
"""

import numpy as np
from rod import ANGLES, parallel_rod, tension
from scipy.optimize import brentq

E = np.stack([np.cos(ANGLES), np.sin(ANGLES)], axis=1)


def polar(bend_angle, plane_angle):
    return bend_angle * np.array([np.cos(plane_angle), np.sin(plane_angle)])


def balance(arm, bend):
    """Return lengths (3,), tensions (3,) of mean 0 that hold the bend, and least and most T0 that the muscles allow.

    Every pressure is from min_pressure to max_pressure and every tension at least min_tension; none where least > most.
    """
    lengths = arm.length - arm.muscle_radius * E @ bend
    tensions = 2 * arm.bending_stiffness / (3 * arm.muscle_radius * arm.length) * E @ bend
    per_pascal, _ = tension(1.0, lengths, arm)
    floor = np.maximum(arm.muscle.min_pressure * per_pascal, arm.muscle.min_tension)
    return lengths, tensions, (floor - tensions).max(), (arm.muscle.max_pressure * per_pascal - tensions).min()


def held(arm, bend, share):
    """Return the rod held by pressures at a share of the range of T0, and the pressures [Pa]."""
    lengths, tensions, least, most = balance(arm, bend)
    pressures = (tensions + least + share * (most - least)) / tension(1.0, lengths, arm)[0]
    return parallel_rod(arm, pressures=pressures), pressures


def stiffness(arm, bend, share):
    """Return the tip's stiffness [N/m], 1/(d . C d): towards more bend, sideways, and normal to both (along)."""
    rod, _ = held(arm, bend, share)
    angle = np.hypot(*bend)
    radial, up = np.append(bend / angle, 0.0), np.array([0.0, 0.0, 1.0])
    # The tip is L ((1 - cos a)/a, sin(a)/a): its derivative by a.
    more = radial * (np.sin(angle) / angle - (1 - np.cos(angle)) / angle**2)
    more = more + up * (np.cos(angle) / angle - np.sin(angle) / angle**2)
    more /= np.linalg.norm(more)
    sideways = np.cross(up, radial)
    directions = np.stack([more, sideways, np.cross(more, sideways)])
    return 1 / np.einsum("ka,ab,kb->k", directions, rod.compliance[:3, :3], directions)


def largest_bend(arm, plane_angle):
    """Return the largest bend angle [rad] up to pi that pressures hold in a plane, every smaller one held too."""

    def slack(angle):
        *_, least, most = balance(arm, polar(angle, plane_angle))
        return most - least

    angles = np.linspace(0, np.pi, 181)
    lost = [angle for angle in angles if slack(angle) < 0]
    return brentq(slack, lost[0] - angles[1], lost[0]) if lost else np.pi
