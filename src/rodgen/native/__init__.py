"""Step loops as C99 that any rod can be stepped by, and what builds and loads C.

`rodgen derive` puts this folder beside its modules, which need nothing else of rodgen.
"""
