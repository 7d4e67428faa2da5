"""Every equation and every method of the thesis as printed, compared with what is derived."""
