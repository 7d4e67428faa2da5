"""Linear models of rods, for their control: matrices between inputs and outputs."""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rodgen.analyse.analysis_guard import check_whole_number
from rodgen.analyse.state_space import StateSpace, minimal_part, slow_part, static_gain
from rodgen.analyse.steady_rod import TIME, StateResult
from rodgen.arrays import Array
from rodgen.display import Plottable
from rodgen.errors import InputError, install_command
from rodgen.loading.cache import write_whole
from rodgen.result import Note, Row, omit_from_tables
from rodgen.scene.plain_tables import to_plain
from rodgen.system import System

if TYPE_CHECKING:
    import control
    import scipy.signal

STATE, INPUT, OUTPUT = "state", "input", "output"


ROUNDED = 1e-11  # of the terms of a rate: one that is zero but for rounding


def _hide_in_equilibrium(found: LinearModel) -> str | None:
    """Leave the constant rates out where they are rounding."""
    return None if found.in_equilibrium else ""


@dataclass(frozen=True, repr=False)
class LinearModel(StateResult, Plottable):
    """Linear model x' = rates + A x + B u, y = output_values + C x + D u, of small changes.

    A: of the rates by the states, (states, states), in SI units; B: of the rates by the inputs,
    (states, inputs), in SI units; C: of the outputs by the states, (outputs, states), in SI units;
    D: of the outputs by the inputs, (outputs, inputs), in SI units; rates: of the states without
    changes, (states,), in SI units, zero about an equilibrium; states: their names; state_units:
    units of them, such as rad/s; point: where their changes begin, (states,), in SI units; inputs:
    their names; input_units: units of them; input_values: where their changes begin, (inputs,), in
    SI units, not-a-number of one with several values; outputs: their names; output_units: units of
    them; output_values: outputs without changes, (outputs,), in SI units; basis: changes of the
    rod's states over those of the model, (rod's states, states), in SI units; about: the state in
    words; notes: what makes it doubtful, and what to know; system: the rod, with the loads of one
    time.

    Examples
    --------
    >>> import rodgen
    >>> missile = rodgen.Scene.example("missile")
    >>> model = rodgen.linearise(missile, ["loads.follower.angle"], ["omega(0.2)"], t=1.0)
    >>> model.A.shape, model.B.shape, model.C.shape, model.output_units, model.in_equilibrium
    ((44, 44), (44, 1), (1, 44), ('rad/s',), False)
    >>> small = model.minimal().reduce(3)
    >>> len(small.states), small.to_scipy().A.shape == small.A.shape, small.stable
    (7, True, False)
    """

    A: Array
    B: Array
    C: Array
    D: Array
    rates: Array
    states: tuple[str, ...]
    state_units: tuple[str, ...]
    point: Array
    inputs: tuple[str, ...]
    input_units: tuple[str, ...]
    input_values: Array
    outputs: tuple[str, ...]
    output_units: tuple[str, ...]
    output_values: Array
    basis: Array
    about: str
    notes: tuple[Note, ...] = ()
    system: System = field(kw_only=True, compare=False)

    ROWS = (
        Row("about", "about"),
        *TIME,
        Row("inputs", "input", along=INPUT),
        Row("input_units", "unit", along=INPUT),
        Row("input_values", "value", "", ".6g", along=INPUT),
        Row("outputs", "output", along=OUTPUT),
        Row("output_units", "unit", along=OUTPUT),
        Row("output_values", "value", "", ".6g", along=OUTPUT),
        Row("states", "state", along=STATE),
        Row("state_units", "unit", along=STATE),
        Row("point", "value", "", ".6g", along=STATE),
        Row("rates", "constant rate", "", ".6g", along=STATE, text=_hide_in_equilibrium),
        Row("eigenvalues", "eigenvalue", "1/s", ".6g", along="eigenvalue"),
        *(Row(name, name, text=omit_from_tables) for name in "ABCD"),
    )

    @property
    def eigenvalues(self) -> NDArray[np.complex128]:
        """Eigenvalues of A [1/s], by modulus."""
        s = np.linalg.eigvals(self.A).astype(complex)
        return s[np.argsort(np.abs(s), kind="stable")]

    @property
    def in_equilibrium(self) -> bool:
        """Whether no state changes where it is linearised, beyond rounding."""
        terms = np.abs(self.A) @ np.abs(self.point) + np.abs(self.B) @ np.abs(self.input_values)
        return bool((np.abs(self.rates) <= ROUNDED * (terms + 1)).all())

    @property
    def stable(self) -> bool:
        """Whether all that it has dies away."""
        return bool((self.eigenvalues.real < 0).all())

    @property
    def static_gain(self) -> Array:
        """Outputs over inputs that do not change (outputs, inputs), in SI units; not-a-number where
        an output sees a state that the input sets going on by itself, such as a turning rod's
        angle."""
        return static_gain(self._state_space)

    def response(self, frequencies: ArrayLike) -> NDArray[np.complex128]:
        """Frequency response, outputs over inputs (frequencies, outputs, inputs).

        frequencies: (k,) [Hz]. Not-a-number at the frequency of a motion without damping. At zero
        it is the static gain.

        Raises InputError for what are no finite numbers.
        """
        try:
            given = np.atleast_1d(np.asarray(to_plain(frequencies, "frequencies"), dtype=float))
        except (TypeError, ValueError):
            given = np.full(1, np.nan)
        if given.ndim != 1 or not np.isfinite(given).all():
            raise InputError("frequencies", frequencies, "finite numbers (k,) [Hz]")
        made = np.full((len(given), *self.D.shape), np.nan, dtype=complex)
        for at, s in enumerate(2j * np.pi * given):
            try:
                moved = np.linalg.solve(s * np.eye(len(self.A)) - self.A, self.B)
            except np.linalg.LinAlgError:
                continue
            made[at] = self.D + self.C @ moved
        made[given == 0.0] = self.static_gain
        return made

    def reduce(self, modes: int) -> LinearModel:
        """The model of its lowest modes, with what is faster as though it followed at once: the
        static gain is kept.

        modes: how many pairs of eigenvalues, those of smallest modulus; a mode without frequency, a
        rigid motion of the rod, is a pair of zeros. Pairs are not split, and all zeros stay
        together: a free rod has six. States are combinations, which `basis` tells.

        Raises InputError for what is no whole number above zero.
        """
        count = 2 * check_whole_number(modes, "modes", 1)
        return self._of_part(*slow_part(self._state_space, count))

    def minimal(self) -> LinearModel:
        """The model without what no input reaches or no output sees, such as the fall of a rod
        whose angles are measured; inputs and outputs are as they were. Beyond some 50 links
        rounding hides what is not reached: reduce first."""
        return self._of_part(*minimal_part(self._state_space))

    @property
    def _state_space(self) -> StateSpace:
        """Its matrices and constants."""
        return StateSpace(self.A, self.B, self.C, self.D, self.rates, self.output_values)

    def _of_part(self, part: StateSpace, basis: Array) -> LinearModel:
        if len(part.A) == len(self.A):
            return self
        count = len(part.A)
        return replace(
            self,
            A=part.A,
            B=part.B,
            C=part.C,
            D=part.D,
            rates=part.rates,
            states=tuple(f"z_{at}" for at in range(1, count + 1)),
            state_units=("",) * count,
            point=np.zeros(count),
            output_values=part.values,
            basis=self.basis @ basis,
        )

    def to_scipy(self) -> scipy.signal.StateSpace:
        """Convert to scipy.signal.StateSpace, without the constant rates."""
        import scipy.signal

        return scipy.signal.StateSpace(self.A, self.B, self.C, self.D)

    def to_control(self) -> control.StateSpace:
        """Convert to control.StateSpace of python-control, without the constant rates. In names,
        which may have no point there, "_" stands for it.

        Raises ImportError where python-control is not installed, InputError without inputs, which
        it does not know.
        """
        try:
            import control
        except ImportError:
            raise ImportError(
                f"to_control needs python-control: {install_command('control')}"
            ) from None
        if not self.inputs:
            raise InputError("inputs", [], "one at least in a model for python-control")
        named = {"states": self.states, "inputs": self.inputs, "outputs": self.outputs}
        words = {of: [name.replace(".", "_") for name in names] for of, names in named.items()}
        return control.ss(self.A, self.B, self.C, self.D, **words)

    def to_csv(self, path: str | Path) -> None:
        """Write one table: a row for the rate of each state, then one for each output; a column for
        each state and each input, then what is constant.

        path: of the file, which is replaced. Numbers have all their digits.
        """
        whole = np.block(
            [[self.A, self.B, self.rates[:, None]], [self.C, self.D, self.output_values[:, None]]]
        )
        rows = (*(f"d/dt {name}" for name in self.states), *self.outputs)
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(("", *self.states, *self.inputs, "constant"))
        writer.writerows(
            (name, *map(repr, row)) for name, row in zip(rows, whole.tolist(), strict=True)
        )
        write_whole(Path(path), text.getvalue())

    def __repr__(self) -> str:
        counts = (
            f"{len(names)} {word}{'s' * (len(names) != 1)}"
            for names, word in ((self.states, STATE), (self.inputs, INPUT), (self.outputs, OUTPUT))
        )
        return f"<LinearModel of {self.scene.name}: {', '.join(counts)}, about {self.about}>"
