"""Two sections and a tip position: all solutions are curves of one parameter, in closed form."""
