"""Step loops in C99 for any rod, and Python that builds and loads C.

`rodgen derive` puts this folder beside its modules, which need nothing else of rodgen.
"""
