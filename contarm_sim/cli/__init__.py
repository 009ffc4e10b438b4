"""The command line, `contarm`."""
