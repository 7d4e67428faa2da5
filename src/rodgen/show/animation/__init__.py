"""A run as a film: MP4 or GIF."""
