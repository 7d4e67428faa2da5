"""Verdicts of stability on random scenes, against eigenvalues in 50-digit arithmetic.

python -m rodgen_evidence.verdicts

The reference shares nothing with rodgen but the text of a scene: it assembles the chain of links
anew, finds its rest along the load, and linearises it by differences.
"""
