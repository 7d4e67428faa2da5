"""Methods: one a file, what chooses among them, and what walks with them."""
