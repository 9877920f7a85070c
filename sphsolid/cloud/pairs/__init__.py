"""Sums over pairs of particles: who sees whom, and how that is stored so that it is fast."""
