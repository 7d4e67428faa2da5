"""Where numbers stop being right: largest steps, stiff and extreme cases, rounding."""
