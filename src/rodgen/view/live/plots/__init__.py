"""Plots of a live run: what was chosen, and the rows that go to the page."""
