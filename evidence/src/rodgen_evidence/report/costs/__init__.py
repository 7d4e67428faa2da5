"""Costs: against the number of links, and without what a scene does not need."""
