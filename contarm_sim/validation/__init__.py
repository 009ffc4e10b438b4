"""The comparison of the simulated arm with the closed forms: the only place where the two derivations meet."""
