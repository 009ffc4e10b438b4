"""Arms fitted to recordings: what was commanded and measured, parameters with intervals, what data do not determine."""
