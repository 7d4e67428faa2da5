"""The pages that the report, the thesis and the audit write."""
