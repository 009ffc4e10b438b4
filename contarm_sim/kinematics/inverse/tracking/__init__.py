"""Paths of targets, followed continuously through the redundancy."""
