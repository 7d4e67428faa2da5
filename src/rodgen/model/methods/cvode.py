"""CVODE's Adams methods of variable order."""

from rodgen.model.method import Method

METHOD = Method(
    place=12,
    order=12,
    steps="adaptive",
    varies=True,
    implicit=True,
    about="Adams methods, by scikit-sundae, with `rodgen[cvode]`",
    citation="A. C. Hindmarsh et al. 2005",
)
