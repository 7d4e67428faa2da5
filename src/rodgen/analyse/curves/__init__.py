"""Curves of solutions of F(u) = 0: their continuation, special points, files and journals."""
