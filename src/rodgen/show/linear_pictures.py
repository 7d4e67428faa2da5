"""Frequency response of linear models."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from rodgen.analyse.linear_model import LinearModel
from rodgen.arrays import Array
from rodgen.errors import EmptyPictureError
from rodgen.model.term import typeset
from rodgen.show.canvas import LINE, SERIES, add_legend, make_axes, set_title

POINTS = 600  # frequencies, beside those of the eigenvalues
BEYOND = 3.0  # times the frequencies of the eigenvalues, below and above
PAIRS = 8  # of an input and an output that are drawn
SLOWEST = 1e-4  # of the largest eigenvalue, that counts: slower ones are rigid motions


def frequency_response(model: LinearModel) -> Figure:
    """Gain and phase over the frequency, from every input to every output, the first eight."""
    pairs = [(o, i) for i in range(len(model.inputs)) for o in range(len(model.outputs))][:PAIRS]
    if not pairs:
        raise EmptyPictureError("inputs", model.inputs, "at least one, and an output")
    hertz = _frequencies(model)
    found = model.response(hertz)
    figure, (upper, lower) = make_axes(6.4, 5.4, 2, sharex=True, height_ratios=(3, 2))
    for number, (o, i) in enumerate(pairs):
        how = {"color": SERIES[number % len(SERIES)], "linewidth": LINE}
        gain, name = np.abs(found[:, o, i]), f"{model.outputs[o]} over {model.inputs[i]}"
        if gain[np.isfinite(gain)].any():
            upper.loglog(hertz, np.where(gain > 0, gain, np.nan), label=name, **how)
            phase = np.unwrap(np.angle(np.nan_to_num(found[:, o, i])))
            lower.semilogx(hertz, np.degrees(phase), **how)
    units = {_ratio(model.output_units[o], model.input_units[i]) for o, i in pairs}
    unit = typeset(units.pop()) if len(units) == 1 else "SI units"
    upper.set(ylabel=f"gain [{unit}]")
    lower.set(xlabel="frequency [Hz]", ylabel="phase [degrees]", xlim=(hertz[0], hertz[-1]))
    lower.yaxis.set_major_locator(MaxNLocator(6, steps=[1.8, 4.5, 9, 10]))
    set_title(figure, f"{model.scene.name}: frequency response, {model.about}")
    add_legend(figure, upper.get_lines())
    return figure


def _frequencies(model: LinearModel) -> Array:
    """Frequencies [Hz] over all eigenvalues but those that are zero, with theirs among them."""
    sizes = np.abs(model.eigenvalues) / (2 * np.pi)
    most = float(sizes.max(initial=0.0)) or 1.0
    least = float(sizes[sizes > SLOWEST * most].min(initial=most))
    even = np.geomspace(least / BEYOND, most * BEYOND, POINTS)
    peaks = np.abs(model.eigenvalues.imag) / (2 * np.pi)
    inside = peaks[(peaks > even[0]) & (peaks < even[-1])]
    return np.unique(np.concatenate((even, inside)))


def _ratio(output: str, given: str) -> str:
    """Unit of a gain."""
    return f"{output or '1'}/({given})" if given else output or "1"


PICTURES_OF = {LinearModel: {"response": frequency_response}}
