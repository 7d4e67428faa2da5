"""Periodic motions: their search, multipliers, and branches, and nonlinear modes."""
