"""Tables of numbers in files beside a scene, which interp(t, 'thrust.csv') names.

A file has columns, of which interp(t, 'test.csv', 'thrust') takes one, or is the thrust curve of a
rocket motor, RASP's (.eng) or RockSim's (.rse). A motor's curve begins at the origin, and where it
ends the thrust does.

Columns are separated by commas, semicolons, tabs or blanks; with all but commas, decimals may have
commas. Lines before the first row of numbers are a header: names of the columns, units.
"""

from __future__ import annotations

import ast
import csv
import math
import re
from collections.abc import Callable, Collection, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from rodgen.errors import InputError, did_you_mean, shorten
from rodgen.scene.grammar import CUBIC, LINEAR, TABLE, parse
from rodgen.scene.lookup_table import KNOTS, MOST_ROWS, VALUES

LARGEST = 50_000_000  # bytes
KINDS = (".csv", ".eng", ".rse")
MOTORS = (".eng", ".rse")
STATIONS = ".csv"  # that the mass of a rod may name
TABLES = "tables"  # where a scene has them
DECLARED = re.compile(r"^\s*<\?xml[^>]*\?>")  # an encoding, of what is text already
BETWEEN = re.compile(r"[,;\s]+")
MOTOR_FIELDS = 7  # of a RASP header: name, diameter, length, delays, two masses, maker

Rows = list[tuple[float, float]]
Refused = Callable[[str], InputError]
COMMENT, EMPTY = "#", ";,\t \x1a"  # what lines may have that have nothing
DECIMAL_COMMA = re.compile(r"[+-]?\d+,\d+(e[+-]?\d+)?", re.IGNORECASE)
UNIT = re.compile(r"\s*(\[[^]]*\]|\([^)]*\))\s*$")  # behind the name of a column
MOST_HEADER = 10  # lines


def read_table_files(scene: dict[str, Any], folder: Path) -> dict[str, Any]:
    """Add the numbers of the files that a scene's expressions name to its tables.

    Raises InputError for a file that cannot be had, is no table, or does not lie in the folder.
    """
    known = scene.get(TABLES, {})
    if not isinstance(known, dict):
        return scene
    reader = _FileReader(folder, known)
    scene = _read_stations(scene, reader)
    made = {key: reader.read(value, key) for key, value in scene.items() if key != TABLES}
    tables = known | reader.found
    return made | ({TABLES: tables} if tables else {})


def _read_stations(scene: dict[str, Any], reader: _FileReader) -> dict[str, Any]:
    """Read the stations that the mass of a rod names a file of."""
    rod = scene.get("rod")
    name = rod.get("mass") if isinstance(rod, dict) else None
    if not (isinstance(rod, dict) and isinstance(name, str) and name.endswith(STATIONS)):
        return scene
    others = {key: value for key, value in rod.items() if key != "mass"}
    return scene | {"rod": others | {"stations": reader.read_stations(name)}}


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

    def read_stations(self, name: str) -> list[list[float]]:
        """Read places and masses of a file of stations. Raises InputError."""
        self._place = "rod.mass"
        return [[*row] for row in self._read_rows(name, None)]

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


def decode(text: bytes, refused: Refused) -> str:
    """Decode a file: UTF-8, UTF-16 with its mark, else Latin-1 as of older instruments."""
    if text.startswith((b"\xff\xfe", b"\xfe\xff")):
        coding = "utf-16"
    elif b"\0" in text:
        raise refused("a file of text")
    else:
        coding = "utf-8-sig"
    try:
        return text.decode(coding)
    except UnicodeDecodeError:
        return text.decode("latin-1")


def read_columns(text: str, name: str | None, refused: Refused) -> Rows:
    """Read the rows of the first column and of one with a name, by default the second.

    Of two rows with the same first or last number the inner one counts, as where a curve jumps from
    zero at its start. Raises InputError.
    """
    header, rows, at = list[str](), Rows(), 1
    between: str | None = None
    for number, whole in enumerate(text.splitlines(), start=1):
        line = whole.partition(COMMENT)[0].strip()
        if not line.strip(EMPTY):
            continue
        if between is None:
            between = _separator(line, 2 if name is None else 1)
            if between is None and len(header) == MOST_HEADER:
                break
            if between is None:
                header.append(line)
                continue
            _check_header(header, between, refused)
            at = 1 if name is None else _column_index(name, header, line, between, refused)
        fields = _split_fields(line, between)
        values = [_parse_number(field) for field in (*fields[:1], *fields[at : at + 1])]
        if len(values) < 2 or not all(map(math.isfinite, values)):
            raise refused(f"a table of columns of numbers (not line {number}: {shorten(line)})")
        rows.append((values[0], values[1]))
    return _drop_repeated_ends(rows)


def _check_header(header: Sequence[str], between: str, refused: Refused) -> None:
    """Raise InputError for a line of a header that is a faulty row of numbers."""
    for line in header:
        fields = _split_fields(line, between)
        if len(fields) > 1 and math.isfinite(_parse_number(fields[0])):
            raise refused(f"a table of columns of numbers (not the line {shorten(line)})")


def _separator(line: str, numbers: int) -> str | None:
    """Separator of a row that begins with so many numbers, "" for blanks; None if it is no row."""
    for between in (";", "\t", "", ","):
        fields = _split_fields(line, between)
        first = map(_parse_number, fields[:numbers])
        if len(fields) > 1 and all(map(math.isfinite, first)):
            return between
    return None


def _split_fields(line: str, between: str) -> list[str]:
    """Fields of a line, without quotes and blanks around them."""
    try:
        rows = csv.reader([line], delimiter=between or " ", skipinitialspace=True)
        found = next(rows) if between else line.split()
    except csv.Error:  # of a field without end
        return []
    return [field.strip().strip("\"'").strip() for field in found]


def _parse_number(field: str) -> float:
    """The number of a field; not-a-number where it is none."""
    if DECIMAL_COMMA.fullmatch(field):
        field = field.replace(",", ".")
    try:
        return math.nan if "_" in field else float(field)
    except ValueError:
        return math.nan


def _column_index(
    name: str, header: Sequence[str], row: str, between: str, refused: Refused
) -> int:
    """Index of the column of a name, from 1 on; row: the first row of numbers."""
    known = [
        [UNIT.sub("", field).casefold() for field in fields]
        for fields in (_split_fields(line, between) for line in header)
        if len(fields) == len(_split_fields(row, between))
    ]
    wanted = name.strip().casefold()
    for names in known:
        if wanted in names[1:]:
            return names.index(wanted, 1)
    there = [one for names in known[:1] for one in names[1:]]
    allowed = f"of a file with the column {name!r} (there is {', '.join(there) or 'no header'})"
    raise refused(allowed + did_you_mean(name, there))


def _drop_repeated_ends(rows: Rows) -> Rows:
    """Drop the first or last row where its neighbour begins with the same number."""
    if len(rows) > 2 and rows[0][0] == rows[1][0]:
        rows = rows[1:]
    if len(rows) > 2 and rows[-1][0] == rows[-2][0]:
        rows = rows[:-1]
    return rows
