"""Mesh files that studies run on, and the script that made them."""
