"""What data tell of parameters: intervals, what is not determined, and in which combinations."""
