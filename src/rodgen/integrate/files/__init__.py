"""Results on the disk: files that grow with a run, and states to go on from."""
