"""What a chain of links tends to as their number grows: references of the continuum."""
