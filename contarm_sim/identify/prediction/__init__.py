"""Where markers are predicted to be: at rest, at rest with memory, in motion; frequency and damping of swings."""
