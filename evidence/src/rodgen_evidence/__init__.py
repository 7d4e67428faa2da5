"""Evidence of how far rodgen can be trusted; it joins the command line by entry points."""
