"""The thesis set beside the truth: its tables and figures, its equations, its listing."""
