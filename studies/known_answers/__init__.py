"""Scenes with an answer to meet: the cable (d'Alembert) and the bending column (a known peak)."""
