"""Plots of one rod as plots of another, as far as it has what they show."""

from __future__ import annotations

from dataclasses import replace

from rodgen.scene import SceneError
from rodgen.view.live.plots.spec import PlotSpec
from rodgen.view.live.quantities.catalogue import Catalogue


def followed(spec: PlotSpec, name: str, before: Catalogue, after: Catalogue) -> PlotSpec | None:
    """The plot under another name, or None where nothing of it is left. What was the last of its
    kind (the tail's) is so again."""

    def same(quantity: str) -> str | None:
        if quantity in before.quantities:
            kind = before.quantities[quantity].kind
            last, now = before.kinds[kind][-1], after.kinds.get(kind, [])
            if quantity == last and len(before.kinds[kind]) > 1 and now:
                return now[-1]
        return quantity if quantity in after.quantities or quantity in after.kinds else None

    y = tuple(dict.fromkeys(new for old in spec.y if (new := same(old)) is not None))
    x, when = same(spec.x), same(spec.when) if spec.when else ""
    if not y or x is None or when is None:
        return None
    try:
        return PlotSpec.from_dict(replace(spec, id=name, y=y, x=x, when=when).to_dict(), after)
    except SceneError:  # a kind that does not go along this rod
        return None
