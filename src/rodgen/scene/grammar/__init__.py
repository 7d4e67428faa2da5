"""Grammar of expressions: which texts are allowed, their values, and their code.

    numbers, the variable, names of numbers, pi, + - * / **, comparisons, `a if c else b`,
    sin cos tan exp log sqrt abs min max tanh, deg of an angle in degrees, interp(x, [knots],
    [values]) and, as a monotone cubic, interp(x, [knots], [values], 'cubic'), and in expressions
    that may follow the motion its states and phi(s) omega(s) x(s) y(s) vx(s) vy(s), the sensors
    at a fixed s in [0, 1]

The text is parsed to a syntax tree (which runs nothing), every node of it is checked against
the list above, and the tree is walked to compute values, to find break points and to print code.
"""

from rodgen.scene.grammar.code_generation import (
    NUMPY,
    Functions,
    Language,
    constant_parts,
    evaluate,
    is_whole_number,
    table_numbers,
    to_source,
)
from rodgen.scene.grammar.derivatives import (
    Pair,
    conditions,
    derivative,
    divisors,
    kinks,
    tables_in_variable,
)
from rodgen.scene.grammar.substitution import (
    abbreviate,
    affine_core,
    replace_names,
    replace_numbers,
    scale_and_offset,
)
from rodgen.scene.grammar.suggestions import suggest, syntax_error
from rodgen.scene.grammar.syntax_tree import (
    MOST_KNOTS,
    InterpolationTable,
    Sensor,
    check_tree,
    children,
    find_tables,
    is_table,
    names_in,
    parse,
    sensors_in,
    signals_in,
    table_in_call,
    table_names,
    written_parts,
)
from rodgen.scene.grammar.table_data import TableData
from rodgen.scene.grammar.vocabulary import (
    ALLOWED,
    CUBIC,
    FUNCTIONS,
    LINEAR,
    OF_STOPS,
    SENSED,
    SLOPE,
    TABLE,
)
