"""Report of how far numbers can be trusted: error against run time, costs, stability, extremes."""
