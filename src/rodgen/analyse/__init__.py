"""Analyses of a scene beside its motion: frequencies, equilibria, critical loads."""
