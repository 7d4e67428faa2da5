"""Continuum references: limits of a chain of links as their number grows."""
