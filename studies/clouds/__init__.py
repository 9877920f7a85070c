"""Lattices, disorder, tetrahedra, files, points: one method on every kind of cloud."""
