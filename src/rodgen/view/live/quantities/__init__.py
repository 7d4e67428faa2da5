"""What can be shown of a live run: quantities by name, and the texts of the panel of values."""
