"""Jinja templates, one for each target: loops, storage and signatures, no mechanics."""
