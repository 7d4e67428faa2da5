"""Error against run time: jobs, references, contestants, work-precision sets."""
