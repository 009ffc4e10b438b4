"""The arm while you watch: steered by hand, in real time, in a browser or in MuJoCo's own viewer."""
