"""Outputs of the functions of a module, by the derivations."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property

from sympy import Add, Expr, Indexed, symbols

from rodgen.derive.energies import Quantities
from rodgen.derive.general import GeneralEquations
from rodgen.derive.link_properties import INERTIAS
from rodgen.derive.loads.air_force import AirForce
from rodgen.derive.loads.contact import Contact
from rodgen.derive.loads.kinds import GeneralisedForces, JointLoad
from rodgen.derive.symbols import alpha, joint, joint_vx, joint_vy, joint_x, joint_y, s
from rodgen.emit.chain_outputs import ChainFunctions, named_outputs, scalar_outputs
from rodgen.emit.forces import forces, point_force
from rodgen.emit.statements import SCALAR, Domain, Outputs, Program
from rodgen.model.terms import EMPTYING

VELOCITIES = tuple(f"{of}_v{axis}" for of in ("start", "tail", "centre") for axis in "xy")
# Acceleration of the frame in which a rod is at rest.
FRAME = symbols("acceleration_x acceleration_y", real=True)
CENTRE, MOMENTUM = ("centre_x", "centre_y"), ("momentum_x", "momentum_y")


@cache
def _cached_quantities(
    equations: GeneralEquations, potentials: tuple[str, ...], law: object
) -> Quantities:
    """Quantities of equations and a law of inertia, with all that they have derived: the parts of a
    module are made one by one."""
    return Quantities(equations, potentials)


@dataclass(frozen=True)
class Functions(ChainFunctions):
    """Outputs of all functions of one structure, by name; compiled where NumPy text is wanted."""

    def mass(self) -> Program:
        """Program of the entries of the mass matrix."""
        return self.compiler.compile(self._mass)

    @cached_property
    def _mass(self) -> Outputs:
        equations, link = self.equations, self.compiler.link
        out: Outputs = {}
        if equations.boundary_condition.translates:
            out["mass_base"] = SCALAR, equations.mass_base
            for axis, entry in zip("xy", equations.mass_base_link, strict=True):
                out[f"mass_{axis}_link"] = link, entry
        out["mass_link"] = link, equations.mass_link
        if link.count > 1:
            out["mass_link_link"] = self.compiler.pair, equations.mass_link_link
        return out

    def dense(self) -> Program:
        """Program of rhs by the mass matrix."""
        equations, link = self.equations, self.compiler.link
        rhs: Outputs = {}
        if equations.boundary_condition.translates:
            for axis, entry in zip("xy", equations.velocity_base_link, strict=True):
                rhs[f"velocity_{axis}_link"] = link, entry
        if link.count > 1:
            rhs["velocity_link_link"] = self.compiler.pair, equations.velocity_link_link
        return self.compiler.compile(self._mass | rhs | self._forces() | self.state_rates)

    def balance(self) -> Program:
        """Program of what acts on a rod at rest, generalised forces and rates of added states, and
        of their derivatives by the state; in a frame that accelerates, where joint 0 moves."""
        works: tuple[GeneralisedForces, ...] = ()
        if self.equations.boundary_condition.translates:
            against = -FRAME[0], -FRAME[1]
            x, y = (self.equations.mass_base * a for a in against)
            works = (GeneralisedForces((x, y), self.equations.angle_force_of_mass(against)),)
        outputs = self._forces(works) | self.state_rates
        return self.compiler.compile(outputs, tangents=dict.fromkeys(outputs, frozenset()))

    def _forces(self, more: Sequence[GeneralisedForces] = ()) -> Outputs:
        """Generalised forces of loads and joints, and some more, without those that vanish."""
        out: Outputs = {}
        works = (*self.equations.generalised_forces.values(), *more)
        if self.equations.boundary_condition.translates:
            for at, axis in enumerate("xy"):
                out[f"force_{axis}"] = SCALAR, Add(*(work.base[at] for work in works))
        if self.has_springs:
            out["link_moment"] = self.compiler.link, self.equations.link_moment
        out["force_link"] = self.compiler.link, Add(*(work.link for work in works))
        return {name: (domain, e) for name, (domain, e) in out.items() if e != 0}

    @cached_property
    def _quantities(self) -> Quantities:
        of = self.equations
        return _cached_quantities(of, self.structure.potentials, INERTIAS[of.inertia])

    @property
    def observables(self) -> dict[str, Outputs]:
        """Outputs of energies, positions and bending moments."""
        quantities = self._quantities
        joints = Domain((joint,), 0, self.n_links)
        energy = {"kinetic": quantities.kinetic_energy}
        if springs := quantities.anchor_energy + (
            quantities.spring_energy if self.has_springs else 0
        ):
            energy["spring"] = springs
        if quantities.load_energy != 0:
            energy["load_energy"] = quantities.load_energy
        arrays = self.equations.arrays
        return {
            "energy": scalar_outputs(energy),
            "joints": {str(base): (joints, arrays[base].value) for base in (joint_x, joint_y)},
            "centre": named_outputs(CENTRE, quantities.centre),
            "bending": {"bending": (joints, quantities.bending_moment)},
        }

    def quantities(self) -> dict[str, Program]:
        """Programs of energies, geometry, moments and forces, for states along leading axes."""
        quantities = self._quantities
        near = named_outputs(CENTRE, quantities.centre_from_start)
        moments = named_outputs(("inertia_x", "inertia_y", "product_xy"), quantities.second_moments)
        observed = self.observables
        outputs = {
            "energy": observed["energy"],
            "joints": observed["joints"],
            "centre": observed["centre"],
            "inertia_moments": near | moments,
            "bending": observed["bending"],
            "forces": forces(self.equations, self.n_links),
        }
        if self.structure.base_parameters:
            outputs["velocities"] = named_outputs(VELOCITIES, quantities.velocities)
        if self.contacts:
            outputs["contacts"] = self.contacts
        if self.air:
            outputs["air"] = self.air
        if self.laws.definitions:
            outputs["signals"] = scalar_outputs(self.laws.signal_expressions)
        return {name: self.compiler.compile(o, batch=True) for name, o in outputs.items()}

    @cached_property
    def contacts(self) -> Outputs:
        """Depth, push and what else switches of contacts; of a wall at every
        joint."""
        equations, out = self.equations, Outputs()
        joints = Domain((joint,), equations.boundary_condition.first_joint, self.n_links)
        for name, load in equations.loads.items():
            if isinstance(load, Contact):
                along = joints if isinstance(load, JointLoad) else SCALAR
                for what, e in load.contact(equations)._asdict().items():
                    if e != 1:  # where nothing switches
                        out[f"{what}_{name}"] = along, e
        return out

    @cached_property
    def air(self) -> Outputs:
        """Velocities of points against the air."""
        return self._of_air(AirForce.flow)

    def _of_air(self, what: Callable[[AirForce, GeneralEquations], Mapping[str, Expr]]) -> Outputs:
        """What is known of the air at every point that it pushes."""
        equations, loads = self.equations, self.equations.loads.items()
        found = ((x, what(load, equations)) for x, load in loads if isinstance(load, AirForce))
        return scalar_outputs({f"{of}_{x}": e for x, every in found for of, e in every.items()})

    @cached_property
    def measures(self) -> Outputs:
        """What may be measured of a rod: places, moments, and airspeeds and angles of attack."""
        observed = self.observables
        places = observed["joints"] | observed["centre"] | observed["bending"]
        return places | self._of_air(AirForce.measures)

    def measure_slopes(self) -> dict[str, Program]:
        """Programs of the derivatives of what may be measured, by the state and by the inputs."""
        measures, inputs = self.measures, self.input_names
        tangents = dict.fromkeys(measures, frozenset[str]())
        ways = {"measured_by_state": None, "measured_by_inputs": inputs}
        return {
            name: self.compiler.compile(measures, tangents=tangents, values=(), by=by)
            for name, by in ways.items()
        }

    def kinetics(self) -> dict[str, Program]:
        """Programs of momenta, the moment of the clamps, forces of supports, and curvatures, for
        states along leading axes; without those that a rod does not have."""
        of, boundary_condition = self._quantities, self.equations.boundary_condition
        about = named_outputs(CENTRE, of.centre_from_start) if boundary_condition.translates else {}
        outputs = {
            "momentum": named_outputs(MOMENTUM, of.momentum),
            "angular_momentum": about | scalar_outputs({"turning": of.angular_momentum}),
        }
        if boundary_condition.is_clamped:
            outputs["reaction_moment"] = scalar_outputs({"holding": of.reaction_moment})
        link = self.compiler.link
        if held := of.support_forces:
            outputs["support_forces"] = named_outputs(("held_x", "held_y", "held_turn"), held, link)
        if starts := of.start_loads:
            outputs["start_loads"] = named_outputs(("start_x", "start_y"), starts, link)
        if springs := boundary_condition.spring_joints(self.n_links):
            domain = Domain((s,), springs.start, springs.stop - 1)
            outputs["curvatures"] = {"curvature": (domain, of.curvature)}
        return {name: self.compiler.compile(o, batch=True) for name, o in outputs.items()}

    def power_program(self) -> Program:
        """Program of the power of every load without potential, for states along leading axes."""
        given = {str(alpha): self.compiler.link}
        return self.compiler.compile(self.power, batch=True, given=given)

    def point_force(self) -> Program:
        """Program of the generalised forces of a force on a point of a link."""
        return self.compiler.compile(point_force(self.equations, self.n_links))

    @cached_property
    def power(self) -> Outputs:
        """Power of every load without potential."""
        power = self._quantities.power
        loads = self.equations.loads
        acting = {
            f"power_{term}": e
            for term, e in power.items()
            if e != 0 and (self.has_springs or not loads[term].across_joints)
        }
        if not self.variable_masses and not any(e.has(joint) for e in acting.values()):
            # The velocities of few joints are asked for: a sum each, not one for every joint.
            acting = {name: e.xreplace(self._velocities(e)) for name, e in acting.items()}
        if self.variable_masses:
            acting[f"power_{EMPTYING}"] = self.variable_masses.power
        return scalar_outputs(acting)

    def _velocities(self, expression: Expr) -> dict[Expr, Expr]:
        """Velocities of single joints, as sums along the chain."""
        arrays, sums = self.equations.arrays, (joint_vx, joint_vy)
        found = [e for e in expression.atoms(Indexed) if e.base in sums]
        return {e: arrays[e.base].value.subs(joint, e.indices[0]) for e in found}
