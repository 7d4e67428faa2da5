"""Curves of solutions of F(u) = 0, their continuation and special points."""
