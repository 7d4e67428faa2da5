"""Results: samples of a run, files that grow with it, and states to go on from."""
