"""docs/derivation.md: its figures are what the code draws, its formulas what the modules compute.

The formulas stand here as they stand on the page, and are assembled by nothing else.
"""

from __future__ import annotations

import re
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rodgen.loading import build
from rodgen.scene.structure import Structure
from rodgen_evidence.figures.model_figures import DIVERGENCE, FIGURES, FLUTTER, save_figures

DOCS = Path(__file__).parents[2] / "docs"
TERMS = ("follower", "gravity", "internal_damping", "external_damping")
VALUES = {"mass": 3.0, "length": 2.0, "bending_stiffness": 30.0, "follower_force": 40.0}
LOADS = {"follower_angle": 0.1, "gravity": 9.81, "internal_damping": 0.2, "external_damping": 0.7}


def test_the_figures_are_those_that_the_code_draws(tmp_path: Path) -> None:
    """In their words, and in the places of their lines to half a point."""
    for drawn in save_figures(tmp_path):
        kept = (DOCS / "pictures" / drawn.name).read_text(encoding="utf-8")
        words, lines = _content(drawn.read_text(encoding="utf-8"))
        kept_words, kept_lines = _content(kept)
        assert words == kept_words
        assert len(lines) == len(kept_lines)
        for line, kept_line in zip(lines, kept_lines, strict=True):
            np.testing.assert_allclose(line, kept_line, atol=0.5)


def _content(svg: str) -> tuple[list[str], list[list[float]]]:
    """Words and paths of a picture, without the shapes of letters."""
    words = re.findall(r"<!-- (.*?) -->", svg)
    assert words
    bare = re.sub(r"<defs>.*?</defs>", "", svg, flags=re.DOTALL)
    paths = re.findall(r'<path d="(.*?)"', bare, flags=re.DOTALL)
    return words, [[float(x) for x in re.findall(r"-?\d+\.?\d*", path)] for path in paths]


def test_the_page_shows_every_figure() -> None:
    page = (DOCS / "derivation.md").read_text(encoding="utf-8")
    assert set(re.findall(r"pictures/(\w+)\.svg", page)) == set(FIGURES)


def test_the_rod_of_the_first_figure_has_links_of_length_one() -> None:
    lines = FIGURES["model_rod"]().axes[0].lines
    (rod,) = (line for line in lines if line.get_gid() == "rod")
    np.testing.assert_allclose(np.hypot(*np.diff(rod.get_data())), 1.0)


def _module(n: int, boundary: str = "free", terms: tuple[str, ...] = (), **values: float) -> Any:
    module = build(Structure(n, boundary, terms=terms))
    given = {**VALUES, **LOADS, "clamp_angle": 0.0, "tip_force_y": 0.0, **values}
    p = module.parameters(**{k: v for k, v in given.items() if k in module.PARAMETERS})
    return module, p


def _by_the_page(n: int, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """M and the right-hand side of a free rod under all loads of the thesis."""
    m, l, k = VALUES["mass"] / n, VALUES["length"] / n, VALUES["bending_stiffness"] / 2.0 * n
    P, nu, g, c_int, c_ext = VALUES["follower_force"], *LOADS.values()
    phi, v0, omega = y[2 : n + 2], y[n + 2 : n + 4], y[n + 4 :]
    e, normal = np.array([np.cos(phi), np.sin(phi)]), np.array([-np.sin(phi), np.cos(phi)])
    w = 1 + 2 * (n - np.arange(n) - 1)
    later = np.minimum.outer(w, w)
    M, Q = np.zeros((n + 2, n + 2)), np.zeros((n + 2, n))
    M[:2, :2] = n * m * np.eye(2)
    M[:2, 2:], M[2:, :2] = m * l / 2 * w * normal, (m * l / 2 * w * normal).T
    M[2:, 2:] = m * l**2 / 2 * later * np.cos(np.subtract.outer(phi, phi))
    M[2:, 2:][np.diag_indices(n)] = m * l**2 * (1 / 3 + n - np.arange(n) - 1)
    Q[:2] = m * l / 2 * w * e
    Q[2:] = m * l**2 / 2 * later * np.sin(np.subtract.outer(phi, phi).T)
    right = Q @ omega**2
    right[1] -= n * m * g
    right[2:] -= m * g * l / 2 * w * np.cos(phi)
    thrust = -P * np.array([np.cos(phi[-1] + nu), np.sin(phi[-1] + nu)])
    right += np.concatenate((thrust, l * normal.T @ thrust))
    for s in range(1, n):
        tau = -k * (phi[s] - phi[s - 1]) - c_int * m * (omega[s] - omega[s - 1])
        right[2 + s] += tau
        right[1 + s] -= tau
    for s in range(n + 1):
        v = v0 + l * normal[:, :s] @ omega[:s]
        bar = phi[max(s - 1, 0) : s + 1].mean()
        across = abs(v[1] * np.cos(bar) - v[0] * np.sin(bar))
        force = -c_ext * (m if 0 < s < n else m / 2) * across * v / np.hypot(*v)
        turned = np.where(np.arange(n) < s, l * normal.T @ force, 0.0)
        right += np.concatenate((force, turned))
    return M, right


@pytest.mark.parametrize("n", [1, 2, 3])
def test_the_equations_of_the_page(n: int) -> None:
    module, p = _module(n, terms=TERMS)
    y = np.random.default_rng(n).standard_normal(len(module.STATE))
    M, right = _by_the_page(n, y)
    np.testing.assert_allclose(module.mass_matrix(y, p), M, rtol=1e-13, atol=1e-13)
    np.testing.assert_allclose(module.rhs(0, y, p)[n + 2 :], np.linalg.solve(M, right), rtol=1e-10)


@pytest.mark.parametrize("n", [2, 3, 6])
def test_the_joint_forces_of_the_page(n: int) -> None:
    """A free rod without loads: blocks, right-hand side, and what the forces do to a link."""
    module, p = _module(n)
    y = np.random.default_rng(n).standard_normal(len(module.STATE))
    m, l, k = VALUES["mass"] / n, VALUES["length"] / n, VALUES["bending_stiffness"] / 2.0 * n
    phi, omega = y[2 : n + 2], y[n + 4 :]
    tau = np.concatenate(([0.0], -k * np.diff(phi), [0.0]))
    turning = tau[:-1] - tau[1:]
    e, normal = (np.array([np.cos(a), np.sin(a)]).T for a in (phi, phi + np.pi / 2))
    N = [3 * np.outer(v, v) for v in normal]
    pull = l / 2 * (omega**2)[:, None] * e - (6 / (m * l) * turning)[:, None] * normal
    A, b = np.zeros((2 * n + 2, 2 * n + 2)), np.zeros(2 * n + 2)
    for s in range(1, n):
        at = slice(2 * s, 2 * s + 2)
        A[at, 2 * s - 2 : 2 * s] = N[s - 1] - np.eye(2)
        A[at, at] = 2 * np.eye(2) + N[s - 1] + N[s]
        A[at, 2 * s + 2 : 2 * s + 4] = N[s] - np.eye(2)
        b[at] = pull[s - 1] + pull[s]
    force = np.zeros((n + 1, 2))
    force[1:-1] = np.linalg.solve(A[2:-2, 2:-2], b[2:-2]).reshape(-1, 2)
    sums = np.array([before + after for before, after in pairwise(force)])
    alpha = 12 / (m * l**2) * turning + 6 / l * (normal * sums).sum(axis=1)
    np.testing.assert_allclose(module.rhs(0, y, p)[n + 4 :], alpha, rtol=1e-10)


@pytest.mark.parametrize("n", [2, 3, 6])
def test_the_linearised_rod_of_the_page(n: int) -> None:
    """lambda^2 M_0 + K + P G against the Jacobian, and the closed frequencies of n = 2 and 3."""
    module, p = _module(n, terms=("follower",), follower_angle=0.0)
    jacobian = module.jac(0, np.zeros(2 * n + 4), p)[n + 3 :, 1 : n + 2]
    k, l, P = VALUES["bending_stiffness"] / 2.0 * n, 2.0 / n, VALUES["follower_force"]
    m, K, G = VALUES["mass"] / n, np.zeros((n + 1, n + 1)), np.zeros((n + 1, n + 1))
    bend = np.diff(np.eye(n), axis=0)
    K[1:, 1:] = k * bend.T @ bend
    G[0, n] = 1.0
    G[1:, n] = l
    G[1:, 1:] -= np.diag(l * (np.arange(n) + 0.5) / n)
    M0 = np.asarray(module.mass_matrix(np.zeros(2 * n + 4), p))[1:, 1:]
    np.testing.assert_allclose(M0 @ jacobian, -(K + P * G), rtol=1e-10, atol=1e-10)
    closed = {2: [24 * k - 3 * P * l], 3: [6 * k - P * l, (162 * k - 21 * P * l) / 5]}
    if n in closed:
        squares = np.sort(-np.linalg.eigvals(jacobian).real)[2:]
        np.testing.assert_allclose(squares, np.sort(closed[n]) / (m * l**2), rtol=1e-9)


@pytest.mark.parametrize(("boundary", "links"), [("clamped", 2), ("clamped", 9), ("cantilever", 5)])
def test_the_buckling_loads_of_the_page(boundary: str, links: int) -> None:
    """At F_c the straight rod has a frequency of zero: the stiffness is singular."""
    angle = np.pi / (4 * links if boundary == "clamped" else 2 * (2 * links - 1))
    load = 4 * VALUES["bending_stiffness"] * (links / 2.0) ** 2 * np.sin(angle) ** 2
    module, p = _module(links, boundary, ("tip_load",), tip_force_x=-load)
    moving = len(module.STATE) // 2
    stiffness = module.jac(0, np.zeros(2 * moving), p)[moving:, :moving]
    singular = np.linalg.svd(stiffness, compute_uv=False)
    assert singular[-1] < 1e-12 * singular[0]


def test_the_critical_forces_of_the_last_figure() -> None:
    assert FLUTTER.critical() == pytest.approx(102.944, abs=1e-3)
    assert DIVERGENCE.critical() == pytest.approx(400 * np.sin(np.pi / 40) ** 2, abs=1e-4)
    assert abs(FLUTTER.eigenvalues(103.0)[0].imag) == pytest.approx(23.02, abs=0.01)


@pytest.mark.parametrize(("force", "grows"), [(82.5, False), (84.0, True)])
def test_a_little_internal_damping_lowers_the_critical_force(force: float, grows: bool) -> None:
    """From 102.9 to 83; the six zeros of the rigid body are left out."""
    module = build(Structure(10, terms=("follower", "internal_damping")))
    given = dict.fromkeys(("mass", "length", "bending_stiffness"), 1.0)
    p = module.parameters(**given, follower_force=force, internal_damping=0.01)
    values = np.linalg.eigvals(module.jac(0, np.zeros(len(module.STATE)), p))
    bending = values[np.argsort(np.abs(values))][6:]
    assert (bending.real.max() > 1e-4) == grows
