"""Columns of the report's tables, by what their rows are of."""

from __future__ import annotations

from rodgen.view.report_tables import Column, count, error, percent, three, time, times, words

WHO = (Column("label", "method", words), Column("shown", "setting", words))
ERRORS = (
    Column("error_phi", "angles [rad]", error),
    Column("error_tail", "tail [m]", error),
    Column("error_modes", "lowest modes [rad]", error),
    Column("error_energy", "energy", error),
    Column("balance", "own energy balance", error),
)
COUNTS = (
    Column("steps", "steps", count),
    Column("rejected", "rejected", count),
    Column("rhs", "rhs", count),
    Column("jacobian", "Jacobians", count),
    Column("factorisations", "factorisations", count),
)
SECONDS = (
    Column("seconds", "run time", time),
    Column("inside", "inside the loop", time),
    Column("rounds", "rounds", count),
)
FAILED = Column("failed", "failed", words)
SETTINGS = (
    *WHO,
    *SECONDS,
    *ERRORS,
    *COUNTS,
    Column("agreed", "rates agree to", error),
    FAILED,
)
SETUP = (
    Column("label", "method", words),
    Column("setup_generate", "generation", time),
    Column("setup_compile", "compilation", time),
)
ORDERS = (
    Column("label", "method", words),
    Column("order", "nominal order", three),
    Column("observed", "observed order", three),
    Column("points", "steps used", count),
    Column("finest", "by the two smallest steps", three),
)
SLOPES = (
    Column("label", "method", words),
    Column("against", "error against", words),
    Column("exponent", "exponent", three),
    Column("order", "nominal order", three),
    Column("points", "settings used", count),
)
REFERENCE = (
    Column("method", "method", words),
    Column("order", "order", three),
    Column("tolerance", "tolerance", error),
    Column("estimate_phi", "estimate: angles [rad]", error),
    Column("estimate_tail", "estimate: tail [m]", error),
    Column("estimate_modes", "estimate: modes [rad]", error),
    Column("estimate_energy", "estimate: energy", error),
    Column("checked_by", "checked by", words),
    Column("check_phi", "difference [rad]", error),
    Column("rhs", "rhs", count),
    Column("seconds", "run time", time),
    FAILED,
)
DUELS = (
    Column("scene", "scene", words),
    Column("asked", "error asked [rad]", error),
    Column("ours", "ours", words),
    Column("ours_error", "its error", error),
    Column("ours_seconds", "its time", time),
    Column("theirs", "theirs", words),
    Column("theirs_error", "its error", error),
    Column("theirs_seconds", "its time", time),
    Column("ratio", "theirs over ours", times),
    Column("rounds", "rounds", count),
    FAILED,
)
GROWTH = (
    Column("scene", "scene", words),
    *WHO,
    Column("rate", "rate [1/s]", three),
    FAILED,
)
COSTS = (
    Column("what", "what", words),
    Column("who", "who", words),
    Column("n", "links", count),
    Column("seconds", "time", time),
    Column("rounds", "rounds", count),
    Column("setup", "set-up", time),
    FAILED,
)
FITS = (
    Column("what", "what", words),
    Column("who", "who", words),
    Column("exponent", "exponent", three),
    Column("from", "from n", count),
    Column("to", "to n", count),
    Column("points", "points", count),
)
_SIZES = (
    Column("operations", "operations", count),
    Column("source_bytes", "source [bytes]", count),
    Column("object_bytes", "object code [bytes]", count),
)
_TIMES = tuple(
    Column(key, title, time)
    for key, title in (
        ("generate", "generation"),
        ("compile", "compilation"),
        ("rhs", "rhs"),
        ("run", "run, rk4"),
        ("run_dop853", "run, dop853"),
    )
)
_SCENE = (Column("scene", "scene", words), Column("n", "links", count))
LEFT_OUT = (
    *_SCENE,
    Column("variant", "module", words),
    *_SIZES,
    *_TIMES,
    Column("same_rates", "rates differ by", error),
    Column("same_motion", "motions differ by", error),
    FAILED,
)
SAVINGS = (
    Column("scene", "scene", words),
    *(Column(column.key, column.title.split(" [")[0], times) for column in (*_SIZES, *_TIMES)),
)
INSTALL = (
    Column("what", "what", words),
    Column("seconds", "time", time),
    Column("bytes", "bytes", count),
    FAILED,
)
STEPS = (
    Column("method", "method", words),
    Column("n", "links", count),
    Column("damping", "damping", words),
    Column("damping_ratio", "damping ratio", three),
    Column("rate", "fastest rate [1/s]", three),
    Column("found", "found [s]", three),
    Column("theory", "theory [s]", three),
    Column("printed", "printed [s]", three),
    Column("off", "off", percent),
    Column("how", "how found", words),
    FAILED,
)
ROUNDING = (
    Column("group", "group", words),
    Column("case", "case", words),
    Column("kind", "rod", words),
    Column("n", "links", count),
    Column("form", "form", words),
    Column("ulps", "error [ulp]", three),
    Column("ulps_input", "unavoidable [ulp]", three),
    Column("condition", "condition", error),
    FAILED,
)
UNSEEN = (
    Column("group", "group", words),
    Column("case", "case", words),
    Column("n", "links", count),
    Column("label", "method", words),
    Column("digits", "digits", three),
    Column("said", "what it came to", words),
)
CUT = "What failed, was stopped or not tried"
FAILURES = (
    Column("section", "section", words),
    Column("what", "what", words),
    Column("failed", "why", words),
    Column("kind", "kind", words),
)
