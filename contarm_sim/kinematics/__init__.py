"""Closed-form kinematics of the inextensible section, NumPy only.

`arc` is bend <-> pose of the constant-curvature arc, `dome` its inverse, `muscles` bend <->
muscle length changes, `chain` the same for the chain of rigid links. `sections` is the kinematics
of several sections, `inverse` its inverse.
"""

from contarm_sim.kinematics import arc, chain, dome, inverse, muscles, sections

__all__ = ["arc", "chain", "dome", "inverse", "muscles", "sections"]
