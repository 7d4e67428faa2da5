"""Periodic motions: found by shooting, their multipliers, their branches, nonlinear modes."""
