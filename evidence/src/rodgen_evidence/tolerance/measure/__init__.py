"""Measurements of a random scene: errors and times of methods, against two tight runs."""
