"""Pictures, films and summaries of results."""
