"""Three sections and a pose of the tip: all solutions, from one scalar equation."""
