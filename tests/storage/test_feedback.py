"""Files of runs whose loads follow the motion, and that have states of their own."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import rodgen
from rodgen.scene import Scene

SCENE = {
    "name": "steered",
    "rod": {"links": 2, "length": 2.0, "mass": 3.0, "bending_stiffness": 30.0},
    "loads": {"follower": {"force": 40.0, "angle": "max(-0.1, min(0.1, gimbal))"}},
    "states": {"gimbal": {"rate": "(-2*phi(0.3) - gimbal)/0.05", "initial": 0.25}},
    "events": [{"quantity": "gimbal", "value": 0.0, "name": "centred", "action": "stop"}],
    "initial": {"omega": 0.1},
    "integrate": {"span": [0.0, 0.5], "output_every": 0.05},
}


def test_a_run_is_read_as_it_was(tmp_path: Path) -> None:
    sol = rodgen.simulate(Scene.from_dict(SCENE), target="numpy", out=tmp_path / "run.nc")
    read = rodgen.load(tmp_path / "run.nc")
    np.testing.assert_array_equal(read.y, sol.y)
    assert [event.name for event in read.events] == ["centred"]
    assert abs(read.events[0].y[-1]) < 1e-9
    assert read.scene.structure == sol.scene.structure
    data = read.to_xarray()
    assert data.state.values.tolist()[-1] == "gimbal"
    assert data.y.sel(state="gimbal").values[0] == 0.25
    # What the thrust did is in the balance, whichever way it was turned.
    assert sol.energy_error < 1e-5
    assert float(np.abs(sol.work["follower"]).max()) > 0.1
