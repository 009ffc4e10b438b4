"""Many cases: designs of experiments over parameters, run in chunks, kept as a table; and uncertain parameters."""
