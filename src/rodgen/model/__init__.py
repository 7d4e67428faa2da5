"""The vocabulary: parts of rods, loads and methods, as plain data that imports nothing.

A boundary, an inertia, a term, a parameter, a quantity and a method of integration is one row here.
Derivations, scenes, generated modules, analyses, pictures, the live page and the tables of the
documentation read them.
"""
