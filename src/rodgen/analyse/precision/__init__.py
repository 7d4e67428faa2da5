"""Work-precision sets: errors of methods against their run time, beside a reference solution."""
