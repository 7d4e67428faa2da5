"""What is printed: the tables of chapters 3 and 4, with their units and stated conditions.

Numbers are kept as text, as they are printed, since the last digit says how far they are rounded.
"""

from __future__ import annotations

from typing import NamedTuple


class Frequency(NamedTuple):
    """A row of table 3.1: frequencies [Hz], deviation [%]."""

    name: str
    boundary: str  # "free" or "cantilever"
    mode: int  # of that boundary, from 1; rigid motions not counted
    analytical: str
    simulated: str
    percent: str


# 3.1: L = 2 m, A = 0.001 m^2, I = 8.33e-9 m^4, E = 210e9 Pa, m = 15700 g, 40 links, step 8e-4 s,
# 50 s. Of the free rod only modes that are symmetric about the middle.
TABLE_3_1 = (
    Frequency("f1, free", "free", 1, "13.2876", "13.3896", "+0.772"),
    Frequency("f3, free", "free", 3, "71.8056", "72.7841", "+1.363"),
    Frequency("f5, free", "free", 5, "177.3140", "176.1263", "-0.670"),
    Frequency("f1, cantilever", "cantilever", 1, "2.1966", "2.1352", "-2.685"),
    Frequency("f2, cantilever", "cantilever", 2, "13.7662", "13.7785", "+0.211"),
    Frequency("f3, cantilever", "cantilever", 3, "38.5457", "38.4750", "-0.059"),
    Frequency("f4, cantilever", "cantilever", 4, "75.5343", "75.6227", "+0.241"),
    Frequency("f5, cantilever", "cantilever", 5, "124.8640", "125.2371", "+0.299"),
)


class FirstFrequency(NamedTuple):
    """A row of table 3.2: f1 of the free rod [Hz], run time [s]. Conditions of table 3.1."""

    links: int
    frequency: str
    seconds: str


TABLE_3_2 = (
    FirstFrequency(10, "12.6271", "3.624"),
    FirstFrequency(15, "13.1993", "6.325"),
    FirstFrequency(20, "13.3815", "9.928"),
    FirstFrequency(25, "13.3893", "16.904"),
    FirstFrequency(30, "13.3895", "25.137"),
    FirstFrequency(35, "13.3896", "36.510"),
    FirstFrequency(40, "13.3896", "50.581"),
)


class Tip(NamedTuple):
    """A row of table 3.3: deflection [m] or rotation [rad] of the tip, deviation [%]."""

    name: str
    analytical: str
    simulated: str
    percent: str


# 3.2: L = 5 m, EI = 100 N m^2, m = 50 g, 50 links, (3.1) and (3.2) with g = 9.81 m/s^2.
TABLE_3_3 = (
    Tip("deflection", "0.0721", "0.0735", "+1.904"),
    Tip("rotation", "0.0196", "0.0198", "+1.020"),
)


class Critical(NamedTuple):
    """A row of tables 3.4 and 3.5: critical force of the free rod [N], deviation from (3.3) [%],
    run time [s]."""

    links: int
    force: str
    percent: str
    seconds: str


# 3.3.1: L = 5 m, EI = 100 N m^2, 200 s; mass, damping and disturbance are not given.
THRUST_COEFFICIENT = "109.54"  # (3.3), of EI/L^2
THRUST = "438.16"  # (3.3) [N]
TABLE_3_4 = (
    Critical(5, "326.12", "-25.571", "1.255"),
    Critical(10, "411.83", "-6.009", "2.397"),
    Critical(15, "426.81", "-2.590", "4.326"),
    Critical(20, "432.05", "-1.394", "7.344"),
    Critical(25, "434.49", "-0.838", "12.042"),
    Critical(30, "435.80", "-0.539", "18.783"),
    Critical(35, "436.59", "-0.358", "27.486"),
    Critical(40, "437.14", "-0.233", "38.478"),
    Critical(45, "437.48", "-0.155", "51.829"),
    Critical(50, "437.91", "-0.057", "71.481"),
)
# The general mass-spring program, FyDiK.
TABLE_3_5 = (
    Critical(10, "400.73", "-8.543", "27.666"),
    Critical(20, "433.27", "-1.116", "84.761"),
    Critical(30, "439.52", "+0.310", "216.790"),
    Critical(40, "441.73", "+0.815", "444.110"),
    Critical(50, "442.75", "+1.048", "825.040"),
)


class CriticalCantilever(NamedTuple):
    """A row of table 3.6: critical force of the cantilever [N], deviation [%]."""

    links: int
    simulated: str
    analytical: str
    percent: str


# 3.3.2: the rod of 3.3.1; the analytical value, (3.4), is for the length L - L/n.
BECK_COEFFICIENT = "20.05"
TABLE_3_6 = (
    CriticalCantilever(5, "93.95", "125.31", "-33.382"),
    CriticalCantilever(10, "88.23", "99.01", "-12.221"),
    CriticalCantilever(15, "85.85", "92.06", "-7.241"),
    CriticalCantilever(20, "84.51", "88.87", "-5.152"),
    CriticalCantilever(25, "83.75", "87.02", "-3.908"),
    CriticalCantilever(30, "83.21", "85.83", "-3.144"),
    CriticalCantilever(35, "82.98", "84.99", "-2.419"),
    CriticalCantilever(40, "82.83", "84.37", "-1.845"),
    CriticalCantilever(45, "82.70", "83.89", "-1.435"),
    CriticalCantilever(50, "82.65", "83.51", "-1.037"),
)


class OfMethods(NamedTuple):
    """A row of tables 4.1 (largest step [s]) and 4.2 (run time [s]), by method."""

    links: int
    euler: str
    semi_implicit_euler: str
    thesis_runge_kutta: str


# 4.2: neither the rod nor the span nor damping is given.
TABLE_4_1 = (
    OfMethods(10, "0.0002", "0.02", "0.025"),
    OfMethods(20, "0.00006", "0.005", "0.005"),
    OfMethods(30, "0.00002", "0.002", "0.002"),
    OfMethods(40, "0.00001", "0.001", "0.001"),
    OfMethods(50, "0.000002", "0.0006", "0.0007"),
)
TABLE_4_2 = (
    OfMethods(10, "18.506", "0.694", "1.328"),
    OfMethods(20, "181.768", "2.739", "8.126"),
    OfMethods(30, "1385.120", "14.253", "31.485"),
    OfMethods(40, "16253.156", "63.996", "111.889"),
    OfMethods(50, "151288.201", "208.206", "263.767"),
)
METHODS = ("euler", "semi_implicit_euler", "thesis_runge_kutta")


def half_unit(printed: str) -> float:
    """Half a unit of the last digit that is printed: by so much it may be rounded."""
    places = len(printed.partition(".")[2])
    return float(0.5 * 10.0**-places)


def digits(printed: str) -> int:
    """Significant digits of a printed number."""
    return len(printed.lstrip("+-0.").replace(".", ""))
