"""A live run: its thread, its samples on their way to the page, and changes while it goes on."""
