"""Dormand and Prince's method of order 8, its error estimated by order 5 and 3."""

from rodgen.model.method import Method

# Of the last part of the dense output over what is tolerated of a step, times its length: the root
# mean square up to which states inside the step are by dense output. Their error is about a seventh
# of what that part adds at most, (4/7)^4 (3/7)^3 of it: of y' = lambda y + t^q, by h |lambda| = 0.5
# to 6 and q = 0 to 8, less than 0.17 of it at 95 of 100 places, and more only where the part is
# next to zero. Close to the limit of stability it is a hundred times that of the step, of a motion
# that dies out.
BETWEEN = 30.0  # times what is tolerated of a step
LARGEST_LAST = BETWEEN / (0.15 * (4 / 7) ** 4 * (3 / 7) ** 3)
HALVED = 2.0**7  # That part falls with the seventh power of a length at least.
MOST_PARTS = 64  # of a step, by each of which there is dense output

METHOD = Method(
    place=5,
    order=8,
    steps="adaptive",
    about="explicit, error control, dense output of order 7",
    citation="E. Hairer, S. P. Norsett, G. Wanner: Solving Ordinary Differential Equations I, II.5",
    scipy="DOP853",
    compiled=True,
    per_step=1 / 60,
)
