"""Studies: one scene at many values, on as many workers as there are, kept in a store."""
