"""Numbers that studies take of a run: orders, noise, folding, extrapolated limits."""
