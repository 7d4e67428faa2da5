"""What things cost: against the number of links, and without what a scene does not need."""
