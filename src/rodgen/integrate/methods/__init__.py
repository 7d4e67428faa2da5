"""Integrators of the methods in rodgen.model.methods, in Python and in C, and their choice."""
