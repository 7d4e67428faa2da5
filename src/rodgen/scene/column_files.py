"""Reading of two columns of numbers from text files, such as CSV.

Columns are separated by commas, semicolons, tabs or blanks; with all but commas, decimals may have
commas. Lines before the first row of numbers are a header: names of the columns, units.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Callable, Sequence

from rodgen.errors import InputError, did_you_mean, shorten

Rows = list[tuple[float, float]]
Refused = Callable[[str], InputError]
COMMENT, EMPTY = "#", ";,\t \x1a"  # what lines may have that have nothing
DECIMAL_COMMA = re.compile(r"[+-]?\d+,\d+(e[+-]?\d+)?", re.IGNORECASE)
UNIT = re.compile(r"\s*(\[[^]]*\]|\([^)]*\))\s*$")  # behind the name of a column
MOST_HEADER = 10  # lines


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
    """Separator of the fields of a row that begins with `numbers` numbers, "" for blanks; None for
    a line that is no row."""
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
