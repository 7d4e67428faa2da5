"""The 50-digit reference, the comparison of a generated module with it, and cached proofs."""
