"""Variants of the consistent operator, one choice changed at a time."""
