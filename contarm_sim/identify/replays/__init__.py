"""A recording predicted and compared: errors, bands, tables."""
