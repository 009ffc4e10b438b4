"""From bends to controls, and corrections by what is seen."""
