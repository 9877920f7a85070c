"""Error against cost: which method for which accuracy."""
