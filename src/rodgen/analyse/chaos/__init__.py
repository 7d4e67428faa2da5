"""How fast neighbouring motions come apart: Lyapunov exponents, and the 0-1 test."""
