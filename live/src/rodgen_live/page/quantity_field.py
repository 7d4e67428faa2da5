"""Field that chooses quantities: first a kind, then which of it along the rod."""

from __future__ import annotations

import re
from collections.abc import Collection

from nicegui import ui

from rodgen.errors import InputError
from rodgen_live.page.fields import show_refusals
from rodgen_live.plot_quantities import KINDS, Catalogue

ALSO = {"centre": "cg", "centre_velocity": "cg"}  # what else is typed to find a kind
STRETCH = re.compile(r"\s*(\d{1,6})\s*(?:-\s*(\d{1,6})\s*)?")
NUMBERED = re.compile(r"_(\d+)(?=_|$)")


class QuantityField:
    """Field that chooses quantities of a rod: a kind that goes along it is one row, with a field of
    its own for which of them once it is chosen, so that a long rod's list is as short as any.
    several: more than one can be chosen."""

    def __init__(self, catalogue: Catalogue, label: str, several: bool):
        self.catalogue, self.several = catalogue, several
        self.families = {kind: _by_number(catalogue.kinds[kind]) for kind in catalogue.along}
        self.field = ui.select(
            self._options(),
            label=label,
            with_input=True,
            multiple=several,
            clearable=True,
            new_value_mode="add-unique",
            key_generator=str,
        )
        self.field.props(f"hide-bottom-space {'use-chips' * several}").classes("rg-wide")
        self.field.on_value_change(self._build_entries)
        self.field.on("keydown.enter", lambda: self.field.run_method("hidePopup"))
        self._box = ui.element("div").classes("rg-knobs")
        self._which: dict[str, ui.input] = {}

    def _options(self) -> dict[str, str]:
        options, quantities = {}, self.catalogue.quantities
        for kind, names in self.catalogue.kinds.items():
            title, also = KINDS[kind].title, f", {ALSO[kind]}" if kind in ALSO else ""
            first, last = (quantities[names[at]] for at in (0, -1))
            unit = f" [{first.unit}]" if first.unit else ""
            if kind in self.families:
                options[kind] = f"{title}, {first.label} to {last.label}{unit}  ({kind})"
                continue
            for name in names:
                label = quantities[name].label
                options[name] = f"{label if label != name else title}{also}{unit}  ({name})"
        return options

    @property
    def _choices(self) -> list[str]:
        value = self.field.value
        return list(value or []) if self.several else [value] if value else []

    def _build_entries(self) -> None:
        """Build a field for each chosen kind along the rod, with the text that it had before."""
        before, self._which = self._which, {}
        self._box.clear()
        for kind in self._choices:
            if kind in self.families:
                numbers = self.families[kind]
                shown = before[kind].value if kind in before else str(max(numbers))
                label = f"which {KINDS[kind].title}, {_allowed_text(numbers, self.several)}"
                with self._box:
                    self._which[kind] = ui.input(label, value=shown).props("hide-bottom-space")

    def names(self) -> list[str]:
        """Names of the chosen quantities; for a kind that was chosen as a whole its own. A number
        that the rod does not have is refused beside its field. Raises InputError."""
        found: list[str] = []
        for chosen in self._choices:
            if chosen not in self._which:
                found.append(chosen)
                continue
            numbered = self.families[chosen]
            try:
                numbers = which(str(self._which[chosen].value or ""), numbered, self.several)
            except InputError as error:
                show_refusals(self._which, {chosen: f"must be {error.allowed}"})
                raise
            show_refusals(self._which, {})
            found += [numbered[number] for number in numbers] or [chosen]
        return found


def which(text: str, known: Collection[int], several: bool) -> list[int]:
    """Parse the numbers in a text such as "0, 5-9"; none for "all". Raises InputError for one that
    is not known, or for several where one is asked."""
    if several and text.strip() == "all":
        return []
    found: list[int] = []
    for part in text.split(","):
        ends = STRETCH.fullmatch(part)
        numbers = range(int(ends[1]), int(ends[2] or ends[1]) + 1) if ends else range(0)
        found += numbers if numbers and numbers[-1] in known else [-1]
    if not {*found} <= {*known} or (len(found) > 1 and not several):
        raise InputError("which", text, _allowed_text(known, several))
    return list(dict.fromkeys(found))


def _allowed_text(known: Collection[int], several: bool) -> str:
    ends = f"{min(known)} to {max(known)}"
    return f"of {ends}: such as 0, 5-9, or all" if several else f"one of {ends}"


def _by_number(names: list[str]) -> dict[int, str]:
    numbers = (NUMBERED.search(name) for name in names)
    return {int(of[1]): name for of, name in zip(numbers, names, strict=True) if of}
