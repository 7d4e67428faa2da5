"""The vocabulary: parts of rods, loads and methods, as plain data that imports nothing.

A boundary, an inertia, a term and a parameter is one row here, a method of integration one file.
Derivations, scenes, generated modules, analyses, pictures, the live page and the tables of the
documentation read them.
"""
