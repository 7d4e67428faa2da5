"""The 50-digit reference, a generated module held against it, and the proofs that are kept."""
