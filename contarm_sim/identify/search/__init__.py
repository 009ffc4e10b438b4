"""How a fit looks for parameters: residuals, losses, starts, least squares, what is held out."""
