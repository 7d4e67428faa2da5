"""The grammar of expressions: which texts are allowed, what they are worth, and their code.

    numbers, the variable, names of numbers, pi, + - * / **, comparisons, `a if c else b`,
    sin cos tan exp log sqrt abs min max tanh, interp(x, [knots], [values]) and, as a monotone
    cubic, interp(x, [knots], [values], 'cubic'), and in expressions that may follow the motion
    its states and phi(s) omega(s) x(s) y(s) vx(s) vy(s), the sensors at a fixed s in [0, 1]

The text is parsed to a syntax tree (which runs nothing), every node of it is checked against
the list above, and the tree is walked to compute values, to find break points and to print code.
"""

from rodgen.scene.grammar.advice import advice, mistake
from rodgen.scene.grammar.affine import core, scale_and_offset
from rodgen.scene.grammar.calculus import Pair, conditions, derivative, divisors, kinks, tables_of
from rodgen.scene.grammar.code import NUMPY, Language, source_of
from rodgen.scene.grammar.substitution import in_brief, with_names, with_values
from rodgen.scene.grammar.syntax import (
    MOST_KNOTS,
    Sensor,
    Table,
    check,
    children,
    is_table,
    names_in,
    parse,
    sensors_in,
    signals_in,
    table_names,
    table_of,
    tables,
)
from rodgen.scene.grammar.table_data import TableData
from rodgen.scene.grammar.values import Functions, constants, data_of, is_whole, value_of
from rodgen.scene.grammar.vocabulary import ALLOWED, CUBIC, FUNCTIONS, LINEAR, SENSED, SLOPE, TABLE

__all__ = [
    "ALLOWED",
    "CUBIC",
    "FUNCTIONS",
    "LINEAR",
    "MOST_KNOTS",
    "NUMPY",
    "SENSED",
    "SLOPE",
    "TABLE",
    "Functions",
    "Language",
    "Pair",
    "Sensor",
    "Table",
    "TableData",
    "advice",
    "check",
    "children",
    "conditions",
    "constants",
    "core",
    "data_of",
    "derivative",
    "divisors",
    "in_brief",
    "is_table",
    "is_whole",
    "kinks",
    "mistake",
    "names_in",
    "parse",
    "scale_and_offset",
    "sensors_in",
    "signals_in",
    "source_of",
    "table_names",
    "table_of",
    "tables",
    "tables_of",
    "value_of",
    "with_names",
    "with_values",
]
