"""How far the numbers can be trusted: error against run time, costs, stability, extremes."""
