"""The swinging cube: orders of convergence of every method."""
