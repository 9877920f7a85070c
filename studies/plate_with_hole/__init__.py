"""Plate with a hole from a mesh file: stress concentration against finite elements."""
