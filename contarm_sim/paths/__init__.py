"""Paths of the tip: shapes in closed form, and from files."""

from contarm_sim.paths.shapes import NAMES, Path, named, require_duration

__all__ = ["NAMES", "Path", "named", "require_duration"]
