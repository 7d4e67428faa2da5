"""Tables of numbers in files beside a scene, which interp(t, 'thrust.csv') names.

A file has columns, of which interp(t, 'test.csv', 'thrust') takes one, or is the thrust curve of a
rocket motor, RASP's (.eng) or RockSim's (.rse). A motor's curve begins at the origin, and where it
ends the thrust does.
"""

from __future__ import annotations

import ast
import math
import re
from collections.abc import Collection
from itertools import pairwise
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from rodgen.errors import InputError, did_you_mean, shorten
from rodgen.scene.column_files import Rows, decode, read_columns
from rodgen.scene.grammar import CUBIC, LINEAR, TABLE, parse
from rodgen.scene.lookup_table import KNOTS, MOST_ROWS, VALUES

LARGEST = 50_000_000  # bytes
KINDS = (".csv", ".eng", ".rse")
MOTORS = (".eng", ".rse")
TABLES = "tables"  # where a scene has them
DECLARED = re.compile(r"^\s*<\?xml[^>]*\?>")  # an encoding, of what is text already
BETWEEN = re.compile(r"[,;\s]+")
MOTOR_FIELDS = 7  # of a RASP header: name, diameter, length, delays, two masses, maker


def read_table_files(scene: dict[str, Any], folder: Path) -> dict[str, Any]:
    """Add the numbers of the files that a scene's expressions name to its tables.

    Raises InputError for a file that cannot be had, is no table, or does not lie in the folder.
    """
    known = scene.get(TABLES, {})
    if not isinstance(known, dict):
        return scene
    reader = _FileReader(folder, known)
    made = {key: reader.read(value, key) for key, value in scene.items() if key != TABLES}
    tables = known | reader.found
    return made | ({TABLES: tables} if tables else {})


class _FileReader(ast.NodeTransformer):
    """Reader of the files that expressions name; found: their tables by name, a column behind a
    colon."""

    def __init__(self, folder: Path, known: Collection[str]):
        self._folder, self._known, self._place, self._changed = folder, known, "", False
        self.found: dict[str, dict[str, list[float]]] = {}

    def read(self, value: Any, place: str) -> Any:
        """Read the files that a value names; returns it with expressions that name tables."""
        if isinstance(value, dict):
            return {k: self.read(v, f"{place}.{k}") for k, v in value.items()}
        if isinstance(value, list):
            return [self.read(v, f"{place}[{at}]") for at, v in enumerate(value)]
        if not isinstance(value, str) or f"{TABLE}(" not in value:
            return value
        self._place, self._changed = place, False
        tree = parse(value, place)
        made = value if tree is None else ast.unparse(self.visit(tree))
        return made if self._changed else value

    def visit_Call(self, node: ast.Call) -> ast.expr:
        self.generic_visit(node)
        match node:
            case ast.Call(
                func=ast.Name(id="interp"), args=[x, ast.Constant(value=str() as name), *more]
            ):
                column, kind = _split_column(more)
                whole = name if column is None else f"{name}:{column}"
                self._changed |= column is not None or whole not in self._known
                table = ast.Call(node.func, [x, ast.Constant(whole), *kind], [])
                if whole in self._known:
                    return table
                if whole not in self.found:
                    pair = map(list, zip(*self._read_rows(name, column), strict=True))
                    self.found[whole] = dict(zip((KNOTS, VALUES), pair, strict=True))
                knots, values = self.found[whole].values()
                begin, first, end, last = knots[0], values[0], knots[-1], values[-1]
                if Path(name).suffix.lower() not in MOTORS:
                    return table
                burns: ast.expr = table
                if last:
                    until = ast.Compare(x, [ast.LtE()], [ast.Constant(end)])
                    burns = ast.IfExp(until, burns, ast.Constant(0.0))
                if first:
                    from_then = ast.Compare(x, [ast.GtE()], [ast.Constant(begin)])
                    burns = ast.IfExp(from_then, burns, ast.Constant(0.0))
                return burns
        return node

    def _read_rows(self, name: str, column: str | None) -> Rows:
        def make_error(allowed: str) -> InputError:
            return InputError(self._place, name, allowed)

        path = self._folder / name
        if Path(name).name != name or path.suffix.lower() not in KINDS:
            allowed = f"a file beside the scene whose name ends in {', '.join(KINDS)}"
            raise make_error(f"{allowed}, or a table of [tables]{did_you_mean(name, self._known)}")
        try:
            if not path.is_file():
                raise make_error("a file in the folder of the scene: there is none of this name")
            if path.stat().st_size > LARGEST:
                raise make_error(f"a file of at most {LARGEST} bytes")
            text = decode(path.read_bytes(), make_error)
        except OSError as error:
            raise make_error(f"a file that can be read ({error})") from None
        kind = path.suffix.lower()
        if kind not in MOTORS:
            return _check_rows(read_columns(text, column, make_error), make_error)
        if column is not None:
            raise make_error(f"a CSV file, to have a column {column!r}: a motor has one curve")
        return (_read_rasp if kind == ".eng" else _read_rocksim)(text.splitlines(), make_error)


def _split_column(more: list[ast.expr]) -> tuple[str | None, list[ast.expr]]:
    """Split the arguments behind a file name into the name of a column, if any, and the rest."""
    match more:
        case [ast.Constant(value=str() as name), *kind] if name not in (LINEAR, CUBIC):
            return name, kind
    return None, more


def _read_rasp(lines: list[str], refused: Any) -> Rows:
    """Thrust [N] over time [s] of a RASP file of one motor, from the origin on."""
    rows = Rows()
    headers = 0
    for number, line in enumerate(lines, start=1):
        text = line.partition(";")[0].strip()
        if not text:
            continue
        row = _parse_pair(text)
        if row is None and len(text.split()) >= MOTOR_FIELDS:
            headers += 1
        elif row is None or headers != 1:
            raise refused(f"a RASP file of one motor (not line {number}: {shorten(text)})")
        else:
            rows.append(row)
    if headers != 1:
        raise refused(f"a RASP file of one motor (this has {headers})")
    return _check_rows(_from_origin(rows), refused)


def _read_rocksim(lines: list[str], refused: Any) -> Rows:
    """Thrust [N] over time [s] of a RockSim file of one motor, from the origin on."""
    text = "\n".join(lines)
    if "<!DOCTYPE" in text or "<!ENTITY" in text:  # which could name other files, or grow
        raise refused("a RockSim file without definitions of its own")
    try:
        motors = ElementTree.fromstring(DECLARED.sub("", text)).findall(".//engine")
    except (ElementTree.ParseError, ValueError) as error:
        raise refused(f"a RockSim file, in XML ({error})") from None
    if len(motors) != 1:
        raise refused(f"a RockSim file of one motor (this has {len(motors)})")
    rows = []
    for at, point in enumerate(motors[0].findall(".//eng-data"), start=1):
        row = _parse_pair(f"{point.get('t', '')} {point.get('f', '')}")
        if row is None:
            raise refused(f"a RockSim file whose points have numbers t and f (not point {at})")
        rows.append(row)
    return _check_rows(_from_origin(rows), refused)


def _from_origin(rows: Rows) -> Rows:
    return rows if rows[:1] and rows[0][0] <= 0 else [(0.0, 0.0), *rows]


def _parse_pair(text: str) -> tuple[float, float] | None:
    """The two finite numbers of a line; None for any other line."""
    try:
        x, y = map(float, filter(None, BETWEEN.split(text)))
    except ValueError:
        return None
    return (x, y) if math.isfinite(x) and math.isfinite(y) else None


def _check_rows(rows: Rows, refused: Any) -> Rows:
    if not 2 <= len(rows) <= MOST_ROWS:
        raise refused(f"a table of 2 to {MOST_ROWS} rows (this has {len(rows)})")
    for (a, _), (b, _) in pairwise(rows):
        if b <= a:
            raise refused(f"a table whose first column ascends (not from {a:g} to {b:g})")
    return rows
