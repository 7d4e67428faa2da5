"""Exudyn: a scene as a kinematic tree of sliders and hinges, by its implicit and explicit methods.

Loads that change with time are called back; thrust turns with the last link.
"""

from __future__ import annotations

from collections.abc import Iterator
from importlib import import_module
from math import cos, sin
from typing import Any

import numpy as np

from rodgen.analyse.precision.contestant import Deadline
from rodgen.analyse.precision.job import SAMPLES, Job, Stretch
from rodgen.arrays import Array
from rodgen_evidence.report.peers import loads
from rodgen_evidence.report.peers.peer import Over, Peer, fastest, runs, stable, steps, whole_steps
from rodgen_evidence.report.peers.tree import KNOWN, Tree

# The types that it declares are not those that it takes.
exu: Any = import_module("exudyn")
items: Any = import_module("exudyn.itemInterface")
exu.config.suppressWarnings = True

MARGIN = 1e-6  # of a sample's distance, by which it may be missed
SOLVERS = {"generalized-alpha": "GeneralizedAlpha", "RK44": "RK44"}


class ExudynRod(Peer):
    """The generalized-alpha method, Exudyn's own choice, with its spectral radius of 0.9; and the
    classical Runge-Kutta method of fourth order."""

    who = target = "Exudyn"
    kind, knows = "step", KNOWN
    orders = {"generalized-alpha": 2.0, "RK44": 4.0}
    # Mass matrices are full, and derivatives are made by differences.
    most, why = {"generalized-alpha": 100, "RK44": 200}, "full matrices, too slow"

    def __init__(self, job: Job, method: str = "RK44"):
        super().__init__(job, method)
        self.tree = Tree.of(job.scene)
        self.container = exu.SystemContainer()
        self.system = self.container.AddSystem()
        self._tree()
        self.enter(Stretch(*job.span, job.sample_times, 0), job.initial_state)
        kinds = exu.OutputVariableType
        self.sensors = [
            self.system.AddSensor(
                items.SensorNode(nodeNumber=0, storeInternal=True, outputVariableType=kind)
            )
            for kind in (kinds.Coordinates, kinds.Coordinates_t)
        ]
        self.system.Assemble()

    def _tree(self) -> None:
        tree, at = self.tree, self.tree.sliders
        size, l, zero = at + tree.links, tree.length, [0.0] * at
        node = self.system.AddNode(
            items.NodeGenericODE2(
                referenceCoordinates=[0.0] * size,
                initialCoordinates=[0.0] * size,
                initialCoordinates_t=[0.0] * size,
                numberOfODE2Coordinates=size,
            )
        )
        sliders = [exu.JointType.PrismaticX, exu.JointType.PrismaticY][:at]
        places = [[*tree.base, 0.0], *[[l, 0.0, 0.0]] * (tree.links - 1)]
        link = self.system.AddObject(
            items.ObjectKinematicTree(
                nodeNumber=node,
                gravity=[0.0, -tree.gravity, 0.0],
                jointTypes=[*sliders, *[exu.JointType.RevoluteZ] * tree.links],
                linkParents=list(range(-1, size - 1)),
                jointTransformations=exu.Matrix3DList([np.eye(3)] * size),
                jointOffsets=exu.Vector3DList([*[[0.0] * 3] * at, *places]),
                linkInertiasCOM=exu.Matrix3DList(
                    [*[np.zeros((3, 3))] * at, *[tree.inertia * np.eye(3)] * tree.links]
                ),
                linkCOMs=exu.Vector3DList([*[[0.0] * 3] * at, *[[l / 2, 0.0, 0.0]] * tree.links]),
                linkMasses=[*zero, *[tree.mass] * tree.links],
                jointPControlVector=[*zero, *tree.stiffness],
                jointDControlVector=[*zero, *tree.damping],
                jointPositionOffsetVector=[*zero, tree.rest, *[0.0] * (tree.links - 1)],
                jointVelocityOffsetVector=[0.0] * size,
            )
        )
        self._loads(link, size - 1)

    def _loads(self, tree: int, last: int) -> None:
        scene = self.job.scene
        tail = self.system.AddMarker(
            items.MarkerKinematicTreeRigid(
                objectNumber=tree, linkNumber=last, localPosition=[self.tree.length, 0.0, 0.0]
            )
        )
        for term, follows in (("follower", True), ("tip_load", False)):
            if term in scene.structure.terms:
                given = {} if scene.time_dependent_loads else {"loadVector": self._force(term, 0.0)}
                load = items.LoadForceVector(markerNumber=tail, bodyFixed=follows, **given)
                if scene.time_dependent_loads:
                    load.loadVectorUserFunction = self._force_function(term)
                self.system.AddLoad(load)

    def _force_function(self, term: str) -> Any:
        def force(_: Any, t: float, __: Any) -> list[float]:
            Deadline.check()
            return self._force(term, t)

        return force

    def _force(self, term: str, t: float) -> list[float]:
        if self.job.scene.time_dependent_loads:
            given = self.given(self.stretch.clip(t))
        else:
            given = self.job.scene.parameters
        if term == "follower":
            P, nu = given["follower_force"], given["follower_angle"]
            return [-P * cos(nu), -P * sin(nu), 0.0]
        return [given["tip_force_x"], given["tip_force_y"], 0.0]

    def enter(self, stretch: Stretch, y: Array) -> None:
        """A state at the start of a stretch."""
        self.stretch, self.y = stretch, y
        self.given = loads.parameters(self.job.scene, stretch.middle, loads.PLAIN)

    def _start(self) -> None:
        data, initial = self.system.systemData, exu.ConfigurationType.Initial
        q, u = map(self.tree.relative, np.split(self.y, 2))
        data.SetODE2Coordinates(q, initial)
        data.SetODE2Coordinates_t(u, initial)

    def settings(self, quick: bool) -> Iterator[float]:
        """Yield steps; of the implicit method from the time between two samples on."""
        first, last = self.job.span
        longest = (last - first) / SAMPLES
        if self.method == "RK44":
            longest = stable(2.8, fastest(self.job).rate)
        return steps(self.job, longest, quick)

    def integrator(self, setting: float) -> Over:
        """Integrate by calls of Exudyn, each over samples that are at one distance."""

        def over(stretch: Stretch, y: Array) -> Array:
            self.enter(stretch, y)
            return np.concatenate([self._run(*run, setting) for run in runs(stretch)])

        return over

    def _run(self, before: float, times: Array, step: float) -> Array:
        """States (times, states) at times of one distance."""
        self._start()
        each = whole_steps(float(times[0]) - before, step)
        settings, distance = _settings(), (float(times[-1]) - before) / len(times)
        at = settings.timeIntegration
        at.startTime, at.endTime, at.numberOfSteps = before, float(times[-1]), each * len(times)
        at.automaticStepSize = at.adaptiveStep = False
        settings.solution.sensors.writePeriod = distance
        kind = getattr(exu.DynamicSolverType, SOLVERS[self.method])
        if not self.system.SolveDynamic(settings, solverType=kind, showHints=False):
            raise ArithmeticError("Exudyn did not come to the end")
        self.counts["nsteps"] += each * len(times)
        states = self._stored_states(times, MARGIN * distance)
        self.y = states[-1]
        return states

    def _stored_states(self, times: Array, margin: float) -> Array:
        q, u = (self.system.GetSensorStoredData(sensor) for sensor in self.sensors)
        rows = np.searchsorted(q[:, 0], times - margin)
        if rows[-1] >= len(q) or np.abs(q[rows, 0] - times).max() > margin:
            raise ArithmeticError("Exudyn stored no state at a sample")
        halves = (self.tree.absolute(found[rows, 1:]) for found in (q, u))
        return np.concatenate(list(halves), axis=1)

    def accelerations(self, t: float, y: Array) -> Array:
        """In rodgen's coordinates."""
        self.enter(Stretch(t - 1.0, t + 1.0, np.array([]), 0), y)
        self._start()
        settings = _settings()
        settings.timeIntegration.startTime, settings.timeIntegration.endTime = t, t + 1.0
        solver = exu.MainSolverImplicitSecondOrder()
        solver.InitializeSolver(self.system, settings)
        found = np.array(self.system.systemData.GetODE2Coordinates_tt())
        solver.FinalizeSolver(self.system, settings)
        return self.tree.absolute(found)


def _settings() -> Any:
    settings = exu.SimulationSettings()
    settings.timeIntegration.verboseMode = 0
    settings.solution.file.write = False
    return settings
