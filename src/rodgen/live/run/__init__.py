"""A live run: its thread, its samples on their way to the page, and what is changed meanwhile."""
