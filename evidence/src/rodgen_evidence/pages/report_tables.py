"""The columns of the report's tables."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from rodgen.analyse.precision.contestant import Measurement, Value
from rodgen.analyse.precision.rows import format_label, format_setting
from rodgen_evidence.page_tables import Column, count, error, percent, three, time, times, words


def add_names(rows: Iterable[Measurement]) -> list[Measurement]:
    """Add the name of the contestant and its setting in words to rows."""
    return [{**row, "label": format_label(row), "shown": format_setting(row)} for row in rows]


# Entries of rows by how they are printed, with their titles.
TITLES: dict[Callable[[Value], str], dict[str, str]] = {
    words: {
        **{key: key for key in ("method", "failed", "scene", "what", "who", "damping", "form")},
        **{key: key for key in ("ours", "theirs", "group", "case", "section", "kind")},
        "label": "method",
        "shown": "setting",
        "against": "error against",
        "why": "why there is none",
        "checked_by": "checked by",
        "variant": "module",
        "how": "how found",
        "said": "what it came to",
        "csv": "table",
    },
    three: {
        "order": "nominal order",
        "observed": "observed order",
        "exponent": "exponent",
        "finest": "by the two smallest steps",
        "rate": "rate [1/s]",
        "damping_ratio": "damping ratio",
        "found": "found [s]",
        "theory": "theory [s]",
        "printed": "printed [s]",
        "digits": "digits",
        "ulps": "error [ulp]",
        "ulps_input": "unavoidable [ulp]",
    },
    error: {
        "error_phi": "angles at the end [rad]",
        "error_angles": "angles [rad]",
        "error_rates": "rates [rad/s]",
        "error_tail": "tail [m]",
        "error_energy": "energy",
        "error_modes": "lowest modes [rad]",
        "balance": "own energy balance",
        "agreed": "rates agree to",
        "tolerance": "tolerance",
        "asked": "error asked [rad]",
        "estimate_phi": "estimate: angles at the end [rad]",
        "estimate_angles": "estimate: angles [rad]",
        "estimate_rates": "estimate: rates [rad/s]",
        "estimate_tail": "estimate: tail [m]",
        "estimate_modes": "estimate: modes [rad]",
        "estimate_energy": "estimate: energy",
        "check_phi": "difference [rad]",
        "ours_error": "its error",
        "theirs_error": "its error",
        "same_rates": "rates differ by",
        "same_motion": "motions differ by",
        "condition": "condition",
    },
    count: {
        **{key: key for key in ("rejected", "rounds", "points")},
        "nsteps": "steps",
        "nfev": "rhs",
        **{key: key for key in ("units", "rows", "failures", "operations", "bytes")},
        "n": "links",
        "njev": "Jacobians",
        "nlu": "factorisations",
        "from": "from n",
        "to": "to n",
        "source_bytes": "source [bytes]",
        "object_bytes": "object code [bytes]",
    },
    time: {
        "seconds": "time",
        "inside": "inside the loop",
        "setup": "set-up",
        "setup_generate": "generation",
        "setup_compile": "compilation",
        "ours_seconds": "its time",
        "theirs_seconds": "its time",
        "generate": "generation",
        "compile": "compilation",
        "run": "run, rk4",
        "run_dop853": "run, dop853",
    },
    percent: {"off": "off"},
    times: {"ratio": "theirs over ours"},
}
_KNOWN = {
    key: Column(key, title, show)
    for show, titles in TITLES.items()
    for key, title in titles.items()
}


def columns(keys: str, **titles: str) -> tuple[Column, ...]:
    """Columns by their keys, in words; titles: of those that have another one here."""
    known = (_KNOWN[key] for key in keys.split())
    return tuple(column._replace(title=titles.get(column.key, column.title)) for column in known)


SETTINGS = columns(
    "label shown seconds inside rounds error_phi error_angles error_rates error_tail error_modes "
    "error_energy balance nsteps rejected nfev njev nlu agreed failed",
    seconds="run time",
)
SETUP = columns("label setup_generate setup_compile")
ORDERS = columns("label order observed points finest why", points="steps used")
SLOPES = columns("label against exponent order points why", points="settings used")
REFERENCE = columns(
    "method order tolerance estimate_phi estimate_angles estimate_rates estimate_tail "
    "estimate_modes estimate_energy checked_by check_phi nfev seconds failed",
    order="order",
    seconds="run time",
)
DUELS = columns(
    "scene asked ours ours_error ours_seconds theirs theirs_error theirs_seconds ratio rounds "
    "failed"
)
GROWTH = columns("scene label shown rate failed")
COSTS = columns("what who n seconds rounds setup failed")
FITS = columns("what who exponent from to points")
_SAVED = (
    *columns("operations source_bytes object_bytes generate compile"),
    Column("rhs", "rhs", time),
    *columns("run run_dop853"),
)
LEFT_OUT = (*columns("scene n variant"), *_SAVED, *columns("same_rates same_motion failed"))
SAVINGS = (
    *columns("scene"),
    *(column._replace(title=column.title.split(" [")[0], show=times) for column in _SAVED),
)
INSTALL = columns("what seconds bytes failed")
STEPS = columns(
    "method n damping damping_ratio rate found theory printed off how failed",
    rate="fastest rate [1/s]",
)
ROUNDING = columns("group case kind n form ulps ulps_input condition failed", kind="rod")
UNSEEN = columns("group case n label digits said")
CUT = "What failed, was stopped or not tried"
FAILURES = columns("section what failed kind", failed="why")
SECTIONS = columns("section units rows failures seconds csv")
