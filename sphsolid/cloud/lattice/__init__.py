"""Differences along the axes of box lattices: summation by parts of order two, four and six."""
