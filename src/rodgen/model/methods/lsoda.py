"""Adams' methods, or backward differentiation where the system is stiff."""

from rodgen.model.method import Method

METHOD = Method(
    place=11,
    order=12,
    steps="adaptive",
    varies=True,
    implicit=True,
    about="Adams or, where it is stiff, backward differentiation",
    citation="L. Petzold 1983",
    scipy="LSODA",
)
