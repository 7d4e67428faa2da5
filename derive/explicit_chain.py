"""A chain of n links in polynomials: positions, means over its mass, springs, virtual work."""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from math import prod

from sympy import Expr, S
from sympy.physics.mechanics import dynamicsymbols
from sympy.polys.rings import PolyElement

from rodgen.model.terms import MOVING_BASE, boundary_of, load_places

from .base_motion import BaseMotion
from .chain import position
from .link_properties import Joint, Rod, centre, spread
from .polynomials import TIME, Calculus
from .symbols import ALPHA, eta, k, l, m, xi


@dataclass
class ExplicitChain:
    """A chain with n links, before its loads and its equations."""

    n: int
    boundary: str = "free"
    inertia: str = "uniform"
    nonuniform: tuple[str, ...] = ()
    terms: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        boundary_condition = self.boundary_condition = boundary_of(self.boundary, self.terms)
        self.motion = BaseMotion.of(load_places(self.terms).get(MOVING_BASE, ""))
        # What is given as functions of time: the place of joint 0, and the angle of the clamp.
        angle = (self.motion.clamp_angle, *self.motion.angle[1:])
        courses = [self.motion.x, self.motion.y, angle]
        moving_ones = [of for of in courses if of[0] not in (0, ALPHA)]
        names = dynamicsymbols(f"given:{len(moving_ones)}", real=True) if moving_ones else ()
        self.courses = dict(zip(names, moving_ones, strict=True))
        self.given: dict[Expr, Expr] = {
            of: q.diff(TIME, order) if order else q
            for q, course in self.courses.items()
            for order, of in enumerate(course)
        }
        clamp = self.given.get(self.motion.clamp_angle, ALPHA)
        moving = list(dynamicsymbols(f"phi{boundary_condition.first}:{self.n}", real=True))
        self.angles: list[Expr] = [clamp] * boundary_condition.first + moving
        # Every angle that a spring knows, and the springs between them.
        root, tail = (
            [size] if size else [] for size in (boundary_condition.root, boundary_condition.tail)
        )
        self.bent = [clamp] * len(root) + self.angles + [clamp] * len(tail)
        self.rod = Rod(self.inertia, self.nonuniform)
        sizes = zip(
            boundary_condition.spring_joints(self.n),
            [*root, *([1] * (self.n - 1)), *tail],
            strict=True,
        )
        self.joints = [self.rod.joint(at, size) for at, size in sizes]
        self.base: list[Expr] = (
            list(dynamicsymbols("x0 y0", real=True)) if boundary_condition.translates else []
        )
        self.coordinates: list[Expr] = self.base + moving
        self.moving = moving
        self.first_joint = boundary_condition.first_joint
        held = [clamp] if boundary_condition.is_clamped else []
        # What all that is computed is polynomial in, and angles; loads add theirs.
        self.constants, self.turning = [m, l, k, xi], [*moving, *held]
        self.constants += [eta] if self.rod.has_offset_mass else []
        differing = [of for joint in self.joints for of in (joint.stiffness, joint.rest)]
        differing += map(self.rod.mass, range(self.n))
        if "bodies" in self.nonuniform or "points" in self.nonuniform:
            differing += [base[q] for q in range(self.n) for base in (*centre, *spread)]
        differing += map(self.rod.length, range(self.n))
        self.constants += [e for e in differing if e.is_Indexed]

    @cached_property
    def calculus(self) -> Calculus:
        """Ring of all polynomials of the chain."""
        return Calculus([*self.coordinates, *self.courses], self.turning, self.constants)

    def point(
        self, link: int, fraction: Expr, beside: Expr = S.Zero
    ) -> tuple[PolyElement, PolyElement]:
        """Position of a point of the chain, or of one beside it, as polynomials."""
        x, y = self.base or [self.given.get(of, of) for of in self.motion.of_start(0)]
        origin = x, y
        x, y = position(origin, self.angles, self.rod.length, link, fraction, beside)
        return self.calculus.poly(x), self.calculus.poly(y)

    def joint(self, s: int) -> tuple[PolyElement, PolyElement]:
        """Position of joint s: the start of link s, for the tail the end of the last link."""
        return self.point(s, S.Zero) if s < self.n else self.point(self.n - 1, S.One)

    def time_derivative(self, poly: PolyElement) -> PolyElement:
        """Time derivative."""
        return self.calculus.diff(poly, TIME)

    def integrate_over_link(self, poly: PolyElement, link: int) -> PolyElement:
        """Integral over the mass of a link."""
        return self.calculus.poly(self.rod.mass(link)) * self.mean(poly, link)

    def mean(self, poly: PolyElement, link: int = 0) -> PolyElement:
        """Mean over the mass of a link: powers of xi, and of eta beside it, become moments."""
        places = [xi, eta] if self.rod.has_offset_mass else [xi]
        parts = self.calculus.coefficients(poly, places)
        return sum(
            (self._moment(powers, link) * c for powers, c in parts.items()),
            start=self.calculus.zero,
        )

    def _moment(self, powers: tuple[int, ...], link: int) -> PolyElement:
        product = prod((x**p for x, p in zip((xi, eta), powers, strict=False)), start=S.One)
        return self.calculus.poly(self.rod.mean(product, link))

    @cached_property
    def link_points(self) -> list[tuple[PolyElement, PolyElement]]:
        """Position of the point at xi of every link, and at eta beside it where there is mass."""
        beside = eta if self.rod.has_offset_mass else S.Zero
        return [self.point(link, xi, beside) for link in range(self.n)]

    def forces_by_base(self) -> list[PolyElement]:
        """Generalised forces that there are because the base moves, by coordinate: of a chain that
        has its equations."""
        raise NotImplementedError

    @property
    def springs(self) -> list[tuple[Joint, Expr, Expr]]:
        """Joints with a spring, and the angles before and after them."""
        ends = pairwise(self.bent)
        return [(joint, *angles) for joint, angles in zip(self.joints, ends, strict=True)]

    def virtual_work(
        self, point: tuple[PolyElement, PolyElement], force: tuple[PolyElement, PolyElement]
    ) -> list[PolyElement]:
        """Generalised forces F . dr/dq of a force at a point, one for every coordinate."""
        diff = self.calculus.diff
        (x, y), (fx, fy) = point, force
        return [diff(x, q) * fx + diff(y, q) * fy for q in self.coordinates]
