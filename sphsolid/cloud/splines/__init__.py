"""A coarse space of splines over any cloud, and linear systems solved on it."""
