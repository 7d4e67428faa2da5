"""Chaos in motions: Lyapunov exponents, Poincaré sections, and the 0-1 test."""
