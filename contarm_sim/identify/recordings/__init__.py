"""Recordings of real arms: what was commanded and measured, the rig about them, their files, and synthetic ones."""
