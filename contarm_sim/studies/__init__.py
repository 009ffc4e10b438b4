"""Questions about an arm, each a function: the only place beside `results` where the two derivations meet."""
