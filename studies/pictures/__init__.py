"""Deformed bodies: stored frames, depth-sorted surfaces, panels."""
