"""The nearest point of the dome: a one-dimensional problem in the meridian plane.

In units of length the dome's profile at h = bend_angle/2 is m(h) = c (sin h, cos h), c = sin(h)/h. Let p be the angle
of its outward normal from +Z (0 at the apex, 2.14 rad at the rim), R(p) its radius of curvature, which falls from 3/4
to 0.53, and e(p) its centre of curvature. F(p) = (m - target) . m'/|m'| vanishes where the offset is normal to the
profile, and obeys F'' + F = R' < 0 over less than half a turn, so it is positive on one interval at most. The distance
therefore has at most two local minima: the *foot*, where F rises through zero, and the rim, if F < 0 there. It has both
only for targets between the curve e and the normals at its two ends, which lie within `_TWO_MINIMA`.

Most targets take the same few steps: twice p <- angle of (target - e(p)), which converges quadratically because e moves
along the normal, and never to a maximum; then one step of Halley's method in h. What has not settled by then, and
what may have two minima, goes to `search`: it is rare.
"""

from __future__ import annotations

import numpy as np

from contarm_sim.kinematics.arrays import Array, polynomial, sinc_and_slope

LARGEST_HALF = 0.5 * np.pi * (1 - 1e-15)  # a few ulps short, so that no rounding makes a bend angle of pi

# Fits in p^2, highest power first, of h/p and of the centre of curvature (e_rho/p, e_z): to 2e-9, 3e-8 and 2e-7.
_HALF = [3.239081e-08, 2.16479e-08, -4.460361e-05, -0.003125022, 0.75]
_CENTRE_RHO = [2.689625e-07, -1.298005e-05, 0.0003433659, -0.005289186, 0.03749962, 2.405276e-08]
_CENTRE_Z = [1.66331e-06, -6.884129e-05, 0.001447774, -0.01598063, 0.05624726, 0.2500002]
_RIM_NORMAL = 2.1377078317359057
_MIDDLE = 0.06, 0.28  # a point amid the centres of curvature
_TWO_MINIMA = 0.19, 0.2499, 0.4053  # largest rho, smallest and largest z

_SETTLED = 1e-5  # Halley's last step [rad]; its error is then of the order of its cube
_FLATTEST = 0.05  # smallest second derivative taken for a minimum's


def step_to_nearest(rho: Array, z: Array) -> tuple[Array, Array]:
    """Return half the bend angle [rad] at the dome's points nearest to targets, and their distances, shape (n,) each.

    A distance of NaN says that the target wants `search_nearest`.

    Args:
        rho: distances from the axis of symmetry in units of length, shape (n,).
        z: heights in units of length, shape (n,).
    """
    p, *work = np.empty((11, *rho.shape))  # reused throughout: fresh memory costs more than the arithmetic
    square, centre, up, *_ = work
    _angle(np.subtract(rho, _MIDDLE[0], out=centre), np.subtract(z, _MIDDLE[1], out=up), p)
    for _ in range(2):
        np.multiply(p, p, out=square)
        centre = polynomial(_CENTRE_RHO, square, centre)
        centre *= p
        up = polynomial(_CENTRE_Z, square, up)
        _angle(np.subtract(rho, centre, out=centre), np.subtract(z, up, out=up), p)
    np.multiply(p, p, out=square)
    p *= polynomial(_HALF, square, up)
    h, distance = _halley(np.minimum(p, LARGEST_HALF, out=p), rho, z, work)
    largest_rho, low, high = _TWO_MINIMA
    distance[(rho < largest_rho) & (z > low) & (z < high)] = np.nan
    return h, distance


def _angle(rho: Array, z: Array, out: Array) -> None:
    """Fill in the angle of a direction from +Z, within those of the profile's normals."""
    np.maximum(rho, 0.0, out=rho)
    np.arctan2(rho, z, out=out)
    np.minimum(out, _RIM_NORMAL, out=out)


def _halley(h: Array, rho: Array, z: Array, work: list[Array]) -> tuple[Array, Array]:
    """Step once towards the foot, h in place; return it and its distance, NaN unless it is a minimum to rounding.

    In the frame that turns with h the profile is (c, 0), its derivatives (c', c), (s, 2 c') with c' = h g and
    s = c'' - c = -2 (c + g), and (a, b) is it minus the target. Then f = c' a + c b, half the squared distance's slope,
    f' = s a + c^2 + c' (c' + 2 b), and f'' = (s' - 2 c') a + (3 s + 2 c) (c' + b) + 4 c c'.
    """
    c, g, k, a, b, slope, second, third, spare, s = work
    y = np.multiply(h, h, out=spare)
    sinc_and_slope(y, (c, g))
    np.multiply(y, g, out=k)
    k += c
    sine = np.multiply(h, c, out=spare)
    np.subtract(c, np.multiply(rho, sine, out=a), out=a)
    a -= np.multiply(z, k, out=b)
    np.multiply(z, sine, out=b)
    b -= np.multiply(rho, k, out=spare)

    fall = np.multiply(h, g, out=k)  # c'
    np.multiply(fall, a, out=slope)
    slope += np.multiply(c, b, out=spare)

    np.add(b, b, out=second)
    second += fall
    second *= fall
    second += np.multiply(c, c, out=spare)
    np.add(c, g, out=s)
    s *= -2.0
    second += np.multiply(s, a, out=spare)

    np.multiply(g, 3.0, out=third)
    third += c
    third /= np.maximum(h, 1e-4, out=spare)  # (c + 3 g)/h = -g', which vanishes at 0
    third -= np.multiply(fall, 2.0, out=spare)
    third *= a
    np.multiply(s, 1.5, out=g)
    g += c
    g *= np.add(fall, b, out=spare)
    third += g
    np.multiply(c, fall, out=g)
    g *= 2.0
    third += g  # f''/2

    convex = np.maximum(second, _FLATTEST, out=spare)
    third *= slope
    third /= convex
    np.subtract(convex, third, out=third)
    slope /= np.maximum(third, _FLATTEST, out=third)
    new = np.clip(np.subtract(h, slope, out=slope), 0.0, LARGEST_HALF, out=slope)
    step = np.subtract(new, h, out=third)
    settled = np.abs(step, out=g) < _SETTLED
    settled &= (second > _FLATTEST) | (new == LARGEST_HALF)

    s *= step
    s *= 0.5
    s += fall
    s *= step
    a += s
    fall *= step
    fall += c
    fall *= step
    b += fall
    a *= a
    a += np.multiply(b, b, out=b)
    a[~settled] = np.nan
    np.copyto(h, new)
    return h, np.sqrt(a, out=a)
