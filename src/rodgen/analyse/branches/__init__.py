"""Branches of equilibria and steady motions, and boundaries of stability."""
