"""The report of a fit: its figures, its words, its page."""
