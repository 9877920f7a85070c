"""Spectrum of the linearised step, and hard cases in time."""
