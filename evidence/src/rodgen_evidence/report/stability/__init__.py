"""Limits of what is right: largest steps, stiff and extreme cases, rounding."""
