"""Printed tables of chapters 3 and 4 of the thesis, with their units and stated conditions.

Numbers are kept as text, as they are printed, since the last digit says how far they are rounded.
"""

from __future__ import annotations

from pandas import DataFrame


def _parse_table(keys: str, lines: str) -> DataFrame:
    """Parse a table of a row a line; numbers of links and of modes are counts."""
    names = keys.split()
    table = DataFrame([line.split() for line in lines.strip().splitlines()], columns=names)
    return table.astype({name: int for name in names if name in ("links", "mode")})


# 3.1: L = 2 m, A = 0.001 m^2, I = 8.33e-9 m^4, E = 210e9 Pa, m = 15700 g, 40 links, step 8e-4 s,
# 50 s. Of the free rod only modes that are symmetric about the middle. mode: of that boundary, from
# 1, rigid motions not counted; frequencies [Hz], deviation [%].
TABLE_3_1 = _parse_table(
    "boundary mode analytical simulated percent",
    """
    free 1 13.2876 13.3896 +0.772
    free 3 71.8056 72.7841 +1.363
    free 5 177.3140 176.1263 -0.670
    cantilever 1 2.1966 2.1352 -2.685
    cantilever 2 13.7662 13.7785 +0.211
    cantilever 3 38.5457 38.4750 -0.059
    cantilever 4 75.5343 75.6227 +0.241
    cantilever 5 124.8640 125.2371 +0.299
    """,
)
TABLE_3_1["name"] = "f" + TABLE_3_1["mode"].astype(str) + ", " + TABLE_3_1["boundary"]
# f1 of the free rod [Hz], run time [s]. Conditions of table 3.1.
TABLE_3_2 = _parse_table(
    "links simulated seconds",
    """
    10 12.6271 3.624
    15 13.1993 6.325
    20 13.3815 9.928
    25 13.3893 16.904
    30 13.3895 25.137
    35 13.3896 36.510
    40 13.3896 50.581
    """,
)
# 3.2: L = 5 m, EI = 100 N m^2, m = 50 g, 50 links, (3.1) and (3.2) with g = 9.81 m/s^2. Deflection
# [m] and rotation [rad] of the tip, deviation [%].
TABLE_3_3 = _parse_table(
    "name analytical simulated percent",
    """
    deflection 0.0721 0.0735 +1.904
    rotation 0.0196 0.0198 +1.020
    """,
)
# 3.3.1: L = 5 m, EI = 100 N m^2, 200 s; mass, damping and disturbance are not given. Critical force
# of the free rod [N], deviation from (3.3) [%], run time [s].
THRUST_COEFFICIENT = "109.54"  # (3.3), of EI/L^2
THRUST = "438.16"  # (3.3) [N]
TABLE_3_4 = _parse_table(
    "links simulated percent seconds",
    """
    5 326.12 -25.571 1.255
    10 411.83 -6.009 2.397
    15 426.81 -2.590 4.326
    20 432.05 -1.394 7.344
    25 434.49 -0.838 12.042
    30 435.80 -0.539 18.783
    35 436.59 -0.358 27.486
    40 437.14 -0.233 38.478
    45 437.48 -0.155 51.829
    50 437.91 -0.057 71.481
    """,
)
# The same by the general mass-spring program, FyDiK.
TABLE_3_5 = _parse_table(
    "links simulated percent seconds",
    """
    10 400.73 -8.543 27.666
    20 433.27 -1.116 84.761
    30 439.52 +0.310 216.790
    40 441.73 +0.815 444.110
    50 442.75 +1.048 825.040
    """,
)
# 3.3.2: the rod of 3.3.1, held; the analytical value, (3.4), is for the length L - L/n. Critical
# forces [N], deviation [%].
BECK_COEFFICIENT = "20.05"
TABLE_3_6 = _parse_table(
    "links simulated analytical percent",
    """
    5 93.95 125.31 -33.382
    10 88.23 99.01 -12.221
    15 85.85 92.06 -7.241
    20 84.51 88.87 -5.152
    25 83.75 87.02 -3.908
    30 83.21 85.83 -3.144
    35 82.98 84.99 -2.419
    40 82.83 84.37 -1.845
    45 82.70 83.89 -1.435
    50 82.65 83.51 -1.037
    """,
)
# 4.2: neither the rod nor the span nor damping is given. Largest steps [s], run times [s].
TABLE_4_1 = _parse_table(
    "links euler semi_implicit_euler thesis_runge_kutta",
    """
    10 0.0002 0.02 0.025
    20 0.00006 0.005 0.005
    30 0.00002 0.002 0.002
    40 0.00001 0.001 0.001
    50 0.000002 0.0006 0.0007
    """,
)
TABLE_4_2 = _parse_table(
    "links euler semi_implicit_euler thesis_runge_kutta",
    """
    10 18.506 0.694 1.328
    20 181.768 2.739 8.126
    30 1385.120 14.253 31.485
    40 16253.156 63.996 111.889
    50 151288.201 208.206 263.767
    """,
)
METHODS = tuple(TABLE_4_1.columns[1:])


def by_method(table: DataFrame) -> DataFrame:
    """Table 4.1 or 4.2 with a row for every method and number of links."""
    return table.melt("links", var_name="method", value_name="printed")


def unit(printed: str) -> float:
    """The last digit that is printed: by half of it the number may be rounded."""
    return float(10.0 ** -len(printed.partition(".")[2]))


def digits(printed: str) -> int:
    """Significant digits of a printed number."""
    return len(printed.lstrip("+-0.").replace(".", ""))
