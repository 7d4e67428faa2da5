"""Errors of runs over their tolerances on random scenes, and what methods cost at equal error.

python -m rodgen_evidence.tolerance

`measure` makes a record of a scene; the other modules print tables of the records.
"""
