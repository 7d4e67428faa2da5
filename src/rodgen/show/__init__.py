"""Runs to pictures and words."""
