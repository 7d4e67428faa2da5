"""What follows from a scene beside its motion: frequencies, equilibria, critical forces."""
