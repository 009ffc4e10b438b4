"""Any number of sections and any goals: damped least squares from several starts."""
