"""What ends a study before it is done."""

from rodgen.extras import how_to_have


class StudyError(RuntimeError):
    """A study could not be finished. Its store keeps the points that are done.

    Examples
    --------
    >>> import rodgen
    >>> scene, vary = rodgen.Scene.example("ziegler"), {"loads.follower.force": [1.5, 3.0]}
    >>> try:
    ...     data = rodgen.study(scene, vary, what="modes", keep=["stable"], workers=1)
    ... except rodgen.StudyError as error:
    ...     print(error)  # the store, if one was given, has what was done
    """


MISSING = f"studies need more: {how_to_have('study')}"
