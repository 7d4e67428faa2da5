"""Costs against n, what leaving out saves, and what an installation is made of."""

from __future__ import annotations

from email.message import Message
from importlib.metadata import PackageNotFoundError
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from rodgen.loading import load_module
from rodgen.scene import Scene
from rodgen_evidence.report.cases import Case, cases, rod
from rodgen_evidence.report.contents import frame
from rodgen_evidence.report.costs import against_n, install, leaving_out, rates
from rodgen_evidence.report.costs.cold import cold
from rodgen_evidence.report.costs.cost_rows import compare_costs, parameter_vector, row
from rodgen_evidence.report.interleaved_timing import time_in_turns

GENERATED = Path(__file__).parents[3] / "generated"
LINKS = (10, 20, 50, 100, 200, 500, 1000, 2000)


def _rows(seconds: Any, who: str = "one") -> list[Any]:
    return [row("rhs", who, n, seconds(n)) for n in LINKS]


def test_fit_finds_the_exponent() -> None:
    rows = _rows(lambda n: 3e-8 * n**1.7) + _rows(lambda n: 1e-6 + 2e-13 * n**3, "two")
    found = against_n.fits(frame(rows)).set_index("who")
    assert found.loc["one", "exponent"] == pytest.approx(1.7, abs=1e-9)  # exact but for rounding
    # Of the upper half alone, where the cube has won over the constant; of all it would be 1.5.
    assert 2.2 < found.loc["two", "exponent"] < 3.0
    assert tuple(found.loc["two", ["from", "to"]]) == (200.0, 2000.0)


def test_fit_leaves_out_what_failed() -> None:
    rows = _rows(lambda n: 1e-7 * n)
    rows[-1] = row("rhs", "one", 2000, failed="no memory")
    rows.append(row("job", "one", 10, 1.0))
    found = against_n.fits(frame(rows)).set_index("what")["exponent"]
    assert found["rhs"] == pytest.approx(1.0, abs=1e-9)
    assert np.isnan(found["job"])


def test_what_cannot_be_made_is_a_row_and_does_not_end_the_others() -> None:
    def broken() -> Any:
        raise OSError("no such library")

    rows = compare_costs(
        "rhs", 10, {"broken": broken, "good": lambda: lambda number: 1e-3 * number}, True
    )
    by_name = {str(one["who"]): one for one in rows}
    assert by_name["good"]["seconds"] == pytest.approx(1e-3)
    assert by_name["broken"]["failed"] == "no such library"
    assert by_name["broken"]["seconds"] is None


def test_medians_are_those_of_batches_that_take_turns() -> None:
    order: list[str] = []

    def batch(name: str, seconds: float) -> Any:
        def run(number: int) -> float:
            order.append(name)
            return seconds * number

        return run

    times = time_in_turns({"a": batch("a", 1e-3), "b": batch("b", 2e-3)}, rounds=5)
    assert times == pytest.approx({"a": 1e-3, "b": 2e-3})
    assert order[-10:] == ["a", "b"] * 5


def test_a_peer_of_another_model_is_not_timed(monkeypatch: pytest.MonkeyPatch) -> None:
    module = load_module(GENERATED / "rod_free_n5.py")
    monkeypatch.setattr(rates, "built", lambda *_: module)
    monkeypatch.setattr(
        rates, "compare_costs", lambda what, n, made, _: [row(what, who, n, 1e-6) for who in made]
    )

    def of(factor: float) -> Any:
        made = SimpleNamespace(
            rhs=lambda y: factor * module.rhs(0.0, y, parameter_vector(module)), batch=None
        )
        monkeypatch.setattr(rates, "prepare", lambda *_: made)
        (one,) = rates.of_peer("peer", [5])
        return one

    assert of(1.0)["seconds"] == 1e-6
    assert "differ from rodgen's by 1.0e-03" in of(1.001)["failed"]


def test_peer_whose_set_up_explodes_is_not_pursued(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = iter(np.cumsum([0, 1, 1, 3, 3, 30, 30, 900]).tolist())
    monkeypatch.setattr(rates.time, "perf_counter", lambda: next(clock))
    tried: list[int] = []

    def measured(name: str, links: int, _: bool) -> Any:
        tried.append(links)
        return row("rhs", name, links, 1e-6)

    monkeypatch.setattr(rates, "_measure", measured)
    rows = rates.of_peer("peer", LINKS)
    assert tried == [10, 20, 50]  # which took 1, 3 and 30 s
    assert all(made["failed"] for made in rows[3:])
    assert len(rows) == len(LINKS)


# Leaving out ---------------------------------------------------------------------------------


def _case(**tables: Any) -> dict[str, Any]:
    return rod("small", 3, 1.0, loads={"follower": {"force": "300*min(t, 1)"}}, **tables)


def test_every_term_is_there_and_at_zero() -> None:
    whole = Scene.from_dict(leaving_out.with_every_term(_case()))
    assert set(whole.structure.terms) == {
        *("follower", "gravity", "internal_damping", "external_damping", "tip_load")
    }
    values = whole.parameters
    zeros = ("gravity", "internal_damping", "external_damping", "tip_force_x", "tip_force_y")
    assert all(values[name] == 0.0 for name in zeros)
    assert "follower_force" in dict(whole.structure.expressions)  # as the scene has it


def test_scenes_of_one_structure_share_a_unit() -> None:
    made = leaving_out.units(cases(), False)
    names = [str(scene["name"]) for unit in made for scene in unit.arguments["scenes"]]
    few = [case.name for case in cases() if case.scene["rod"]["links"] <= 200]
    assert sorted(names) == sorted(few)
    assert len(made) < len(few)  # below, at and above flutter are one rod
    assert len(leaving_out.units([Case(_case(), "")], True)) == 1


@pytest.fixture
def two_modules(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """The rod of five links without loads and, at zero, with those of the thesis."""
    monkeypatch.delitem(leaving_out.NOTHING, "tip")
    monkeypatch.setattr(leaving_out, "STEPS", 20)  # in Python
    names = {leaving_out.PLAIN: "rod_free_n5_conservative.py", leaving_out.WHOLE: "rod_free_n5.py"}
    return {variant: load_module(GENERATED / name) for variant, name in names.items()}


def test_rows_of_modules_that_agree(two_modules: dict[str, Any]) -> None:
    sizes: dict[str, Any] = {variant: {"operations": 7} for variant in two_modules}
    plain, whole = leaving_out.compare_modules(rod("five", 5, 1.0), two_modules, sizes, True)
    assert (plain["variant"], whole["variant"]) == (leaving_out.PLAIN, leaving_out.WHOLE)
    for made in (plain, whole):
        assert not made["failed"]
        assert made["operations"] == 7
        assert all(float(made[key]) > 0 for key in ("rhs", "run", "run_dop853"))


def test_modules_that_differ_are_found(
    two_modules: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A ten-thousandth of a load where there should be none."""
    monkeypatch.setitem(leaving_out.NOTHING, "gravity", {"g": 1e-3})
    sizes: dict[str, Any] = {variant: {} for variant in two_modules}
    for made in leaving_out.compare_modules(rod("five", 5, 1.0), two_modules, sizes, True):
        assert "rates" in str(made["failed"])
        assert made["run"] is None


def test_motions_that_differ_are_found() -> None:
    leaving_out.check(1e-14, 1e-9)
    with pytest.raises(ArithmeticError, match="motions"):
        leaving_out.check(1e-14, 1e-3)
    with pytest.raises(ArithmeticError, match="rates"):
        leaving_out.check(float("nan"), 0.0)


@pytest.mark.nightly
@pytest.mark.compiler
def test_module_from_cold(tmp_path: Path) -> None:
    table = rod("two", 2, 1.0)
    sizes, model = leaving_out.set_up(table, cold(table, str(tmp_path)), str(tmp_path))
    assert model.N == 2
    assert sizes["operations"] == model.PROVENANCE["operations"]["rhs"]
    assert all(float(sizes[key]) > 0.05 for key in ("generate", "compile"))
    assert sizes["object_bytes"] in [file.stat().st_size for file in tmp_path.rglob("*.so")]


def test_process_that_fails_says_why(tmp_path: Path) -> None:
    with pytest.raises(RuntimeError, match="links"):
        cold(rod("none", 0, 1.0), str(tmp_path))


# Install -------------------------------------------------------------------------------------


class _Made:
    """A distribution of one file, as importlib.metadata has them."""

    def __init__(self, folder: Path, name: str, size: int, requires: list[str], extras: str = ""):
        self.metadata = Message()
        self.metadata["Name"] = name
        for extra in extras.split():
            self.metadata["Provides-Extra"] = extra
        self.requires, self.folder = requires, folder
        self.files = [f"{name}/__init__.py"]
        (folder / name).mkdir()
        (folder / name / "__init__.py").write_bytes(b"#" * size)

    def locate_file(self, file: str) -> Path:
        return self.folder / file


@pytest.fixture
def find(tmp_path: Path) -> Any:
    made = {
        "rodgen": _Made(
            *(tmp_path, "rodgen", 1000),
            [
                *("Middle>=2", 'fast[more]>=1; extra == "c"', 'rodgen[c]; extra == "all"'),
                *('gone; extra == "all"', 'other; python_version < "3"'),
            ],
            "c all",
        ),
        "middle": _Made(tmp_path, "middle", 200, ["leaf", "rodgen"]),
        "leaf": _Made(tmp_path, "leaf", 30, []),
        "fast": _Made(tmp_path, "fast", 4, ['tiny; extra == "more"', 'never; extra == "less"']),
        "tiny": _Made(tmp_path, "tiny", 1, []),
    }

    def found(name: str) -> Any:
        if name not in made:
            raise PackageNotFoundError(name)
        return made[name]

    return found


def test_sizes_add_up_what_is_required(find: Any) -> None:
    rows = {str(made["what"]): made for made in install.sizes(find)}
    assert rows["rodgen itself"]["bytes"] == 1000
    assert rows["rodgen with what it needs"]["bytes"] == 1230
    assert rows["what [c] adds"]["bytes"] == 5
    assert rows["rodgen[all] with what it needs"]["bytes"] == 1235
    assert "gone" in str(rows["rodgen[all] with what it needs"]["failed"])
    assert not rows["rodgen[c] with what it needs"]["failed"]
    assert "never" not in str(rows)


def test_size_of_numpy_is_that_of_its_folders() -> None:
    """By another way: what lies in its folders, which pip has filled."""
    from importlib.metadata import distribution

    places = [Path(np.__file__).parent]
    places += [place for place in (places[0].parent / "numpy.libs",) if place.is_dir()]
    total = sum(f.stat().st_size for place in places for f in place.rglob("*") if f.is_file())
    # Beside them lie a folder of metadata and two small programs.
    assert install.own_bytes(distribution("numpy")) == pytest.approx(total, rel=0.03)


def test_imports_are_timed_without_the_interpreter(tmp_path: Path) -> None:
    (tmp_path / "slow.py").write_text("import time; time.sleep(0.3)")
    codes = {"slow": "import slow", "broken": "import no_such_module"}
    rows = {str(made["what"]): made for made in install._time_imports(codes, str(tmp_path), 1)}
    # It sleeps for 0.3 s; the start of the interpreter varies on a busy machine.
    assert 0.1 < float(rows["slow"]["seconds"]) < 1.5
    assert "no_such_module" in str(rows["broken"]["failed"])
    assert rows["broken"]["seconds"] is None
