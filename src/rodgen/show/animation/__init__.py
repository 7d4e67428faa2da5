"""Films of a run: MP4 or GIF."""
