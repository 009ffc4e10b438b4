"""What is simulated: the arm, its muscles, and what acts on it; read from and written to TOML."""
