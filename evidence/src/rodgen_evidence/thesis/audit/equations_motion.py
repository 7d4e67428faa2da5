"""Equations 2.21 to 2.40: claims on the derivatives of the energies and on what they make."""

from __future__ import annotations

from sympy import Expr, S

from rodgen_evidence.thesis.audit.claim import NOT_PRINTED, READ, Claim
from rodgen_evidence.thesis.audit.equations_energy import (
    matrix_rows,
    printed_euler_lagrange,
)
from rodgen_evidence.thesis.audit.latex import equation
from rodgen_evidence.thesis.audit.truth import truth

TWO_LINKS, THREE_LINKS = range(2, 7), range(3, 7)  # n that have a spring, a link between two


def lagrange(n: int, row: int) -> list[Expr]:
    """d/dt dL/du - dL/dq of x0, y0, or of all angles (row 2)."""
    rows = printed_euler_lagrange(n)
    return rows[2:] if row == 2 else [rows[row]]


def derived_rows(n: int, row: int) -> list[Expr]:
    """M v' - Q omega^2 + K phi of x0, y0, or of all angles (row 2)."""
    rows = matrix_rows(n)
    return rows[2:] if row == 2 else [rows[row]]


def of_link(n: int, at: int) -> str:
    return f"s = {at}"


def lagrange_claim(number: str, row: int, text: str, *repairs: str) -> Claim:
    names = (
        "Lagrange's equation of x0",
        "Lagrange's equation of y0",
        "Lagrange's equations of phi",
    )
    return Claim(
        number,
        names[row],
        {READ: lambda n: lagrange(n, row)},
        lambda n: derived_rows(n, row),
        printed=text,
        repairs=repairs,
        note="Compared with the rows that LagrangesMethod gives.",
        label=of_link if row == 2 else None,
    )


LOST_INDEX = "Ek, Ep stand for E_k, E_p: the index was lost."

CLAIMS: tuple[Claim, ...] = (
    lagrange_claim(
        "2.21",
        0,
        r"\frac{d}{dt} \left(\frac{\partial L}{\partial v_{x0}} \right) "
        r"= \frac{\partial L}{\partial x_0}",
    ),
    lagrange_claim(
        "2.22",
        1,
        r"\frac{d}{dt} \left(\frac{\partial L}{\partial v_{y0}} \right) "
        r"= \frac{\partial L}{\partial y_0}",
    ),
    lagrange_claim(
        "2.23",
        2,
        r"\frac{d}{dt} \left(\frac{\partial L}{\partial \omega_s} \right) "
        r"= \frac{\partial L}{\partial \varphi_s}, \quad s = 0, 1, 2, \dots, n-1",
    ),
    equation(
        "2.24",
        "derivative of E_k by v_x0",
        r"\frac{\partial E_k}{\partial v_{x0}} = \frac{1}{2} m \left\{ 2n v_{x0} "
        r"- l \sum_{i=0}^{n-1} [\omega_i \sin(\varphi_i) (1 + 2(n-i-1))] \right\}",
        lambda n: truth(n).momenta[:1],
    ),
    equation(
        "2.25",
        "derivative of E_k by v_y0",
        r"\frac{\partial E_k}{\partial v_{y0}} = \frac{1}{2} m \left\{ 2n v_{y0} "
        r"+ l \sum_{i=0}^{n-1} [\omega_i \cos(\varphi_i) (1 + 2(n-i-1))] \right\}",
        lambda n: truth(n).momenta[1:2],
    ),
    equation(
        "2.26",
        "derivative of E_k by omega_s",
        r"\frac{\partial E_k}{\partial \omega_s} = \frac{1}{2} m \left\{ 2l^2 \omega_s "
        r"\left(\frac{1}{3} + (n-s-1) \right) - l v_{x0} \sin(\varphi_s) (1 + 2(n-s-1)) "
        r"+ l v_{y0} \cos(\varphi_s) (1 + 2(n-s-1)) "
        r"+ 2l^2 \sum_{i=0}^{s-1} \omega_i \cos(\varphi_s - \varphi_i) "
        r"+ l^2 \omega_{n-1} \cos(\varphi_s - \varphi_{n-1}) \right\}",
        lambda n: truth(n).momenta[2:],
        over=range,
        put_right=(
            r"2l^2 \sum",
            r"l^2 \sum_{i \ne s} (1 + 2(n - \max(i,s) - 1)) \omega_i "
            r"\cos(\varphi_s - \varphi_i) ",
            "the last two terms}",
        ),
        note=(
            "The factor 2 belongs to a single link behind both. The links between s and n-1 are "
            "missing. For s = n-1 the last term pairs a link with itself. Hypothesis: these are "
            "the terms of the last link alone (2.16 with s = n-1, see 2.31), of which one sum "
            "was lost."
        ),
        label=of_link,
    ),
    equation(
        "2.27",
        "rate of the derivative by v_x0",
        r"\frac{d}{dt} \left(\frac{\partial E_k}{\partial v_{x0}} \right) = \frac{1}{2} m "
        r"\left\{ 2n \dot{v}_{x0} - l \sum_{i=0}^{n-1} [\dot{\omega}_i \sin(\varphi_i) "
        r"(1 + 2(n-i-1))] - l \sum_{i=0}^{n-1} [\omega_i^2 \cos(\varphi_i) (1 + 2(n-i-1))] "
        r"\right\}",
        lambda n: truth(n).momentum_rates[:1],
    ),
    equation(
        "2.28",
        "rate of the derivative by v_y0",
        r"\frac{d}{dt} \left(\frac{\partial E_k}{\partial v_{y0}} \right) = \frac{1}{2} m "
        r"\left\{ 2n \dot{v}_{y0} + l \sum_{i=0}^{n-1} [\dot{\omega}_i \cos(\varphi_i) "
        r"(1 + 2(n-i-1))] - l \sum_{i=0}^{n-1} [\omega_i^2 \sin(\varphi_i) (1 + 2(n-i-1))] "
        r"\right\}",
        lambda n: truth(n).momentum_rates[1:2],
    ),
    equation(
        "2.29",
        "rate of the derivative by omega_s",
        r"\frac{d}{dt} \left(\frac{\partial E_k}{\partial \omega_s} \right) "
        r"= \frac{1}{2} m \left\{ 2 l^2 \dot{\omega}_s \left(\frac{1}{3} + (n-s-1) \right) "
        r"- l \dot{v}_{x0} \sin(\varphi_s) (1+2(n-s-1)) "
        r"- l v_{x0} \omega_s \cos(\varphi_s) (1+2(n-s-1)) "
        r"+ l \dot{v}_{y0} \cos(\varphi_s) (1+2(n-s-1)) "
        r"- l v_{y0} \omega_s \sin(\varphi_s) (1+2(n-s-1)) "
        r"+ 2 l^2 \sum_{i=0}^{s-1} \dot{\omega}_i \cos(\varphi_s - \varphi_i) "
        r"- 2 l^2 \sum_{i=0}^{s-1} [\omega_i \omega_s \sin(\varphi_s - \varphi_i) "
        r"+ \omega_i^2 \sin(\varphi_s - \varphi_i)] + l^2 \dot{\omega}_{n-1} "
        r"\cos(\varphi_s - \varphi_i) - l^2 \omega_s \omega_{n-1} \sin(\varphi_{n-1} - \varphi_s) "
        r"+ l^2 \omega_{n-1}^2 \sin(\varphi_{n-1} - \varphi_s) \right\}",
        lambda n: truth(n).momentum_rates[2:],
        over=range,
        as_read=(
            "loose index i read as n-1",
            r"\cos(\varphi_s - \varphi_i) - l^2 \omega_s",
            r"\cos(\varphi_s - \varphi_{n-1}) - l^2 \omega_s",
        ),
        put_right=(
            r"2 l^2 \sum",
            r"l^2 \sum_{i \ne s} (1 + 2(n - \max(i,s) - 1)) [\dot{\omega}_i "
            r"\cos(\varphi_s - \varphi_i) - \omega_i (\omega_s - \omega_i) "
            r"\sin(\varphi_s - \varphi_i)] ",
            "all after the terms in } v_{y0}",
        ),
        note=(
            "It has the terms of 2.26, with their errors. In addition, three signs do not follow"
            " from 2.26: that of omega_i^2 in the sum and those of both last terms. In the term "
            "before them the index i stands outside its sum."
        ),
        label=of_link,
    ),
    Claim(
        "2.30",
        "derivatives of E_k by x0 and y0",
        {READ: lambda n: [S.Zero, S.Zero]},
        lambda n: truth(n).kinetic_slopes[:2],
        printed=r"\frac{\partial E_k}{\partial x_0} = 0, "
        r"\quad \frac{\partial E_k}{\partial y_0} = 0",
        note=(
            "These follow from E_k, which does not depend on the position of the rod. The thesis"
            " gives conditions of equilibrium as the reason."
        ),
    ),
    equation(
        "2.31",
        "derivative of E_k by phi_s",
        r"\frac{\partial E_k}{\partial \varphi_s} = \frac{1}{2} m \left\{ "
        r"- l v_{x0} \omega_s \cos(\varphi_s) (1+2(n-s-1)) "
        r"- l v_{y0} \omega_s \sin(\varphi_s) (1+2(n-s-1)) "
        r"- 2 l^2 \sum_{i=0}^{s-1} \omega_i \omega_s \sin(\varphi_s - \varphi_i) "
        r"+ 2 l^2 \sum_{i=s+1}^{n-2} \omega_s \omega_i \sin(\varphi_i - \varphi_s) "
        r"+ l^2 \omega_s \omega_{n-1} \sin(\varphi_{n-1} - \varphi_s) \right\}",
        lambda n: truth(n).kinetic_slopes[2:-1],
        over=lambda n: range(n - 1),
        put_right=(
            r"- 2 l^2 \sum",
            r"- l^2 \sum_{i \ne s} (1 + 2(n - \max(i,s) - 1)) \omega_i \omega_s "
            r"\sin(\varphi_s - \varphi_i) ",
            "the sums and the last term}",
        ),
        links=TWO_LINKS,
        note=(
            "The terms in two links are those of the last link alone (2.16 with s = n-1), not of"
            " all links. Compared for s < n-1, because 2.32 is for the last link."
        ),
        label=of_link,
    ),
    equation(
        "2.32",
        "derivative of E_k by phi of the last link",
        r"\frac{\partial E_k}{\partial \varphi_{n-1}} = \frac{1}{2} m \left\{ "
        r"- l v_{x0} \omega_{n-1} \cos(\varphi_{n-1}) - l v_{y0} \omega_{n-1} \sin(\varphi_{n-1}) "
        r"- l^2 \sum_{i=0}^{n-2} \omega_i \omega_{n-1} \sin(\varphi_{n-1} - \varphi_i) \right\}",
        lambda n: truth(n).kinetic_slopes[-1:],
    ),
    equation(
        "2.33",
        "derivative of E_p by phi of the first link",
        r"\frac{\partial E_p}{\partial \varphi_0} = k(\varphi_0 - \varphi_1)",
        lambda n: truth(n).spring_slopes[2:3],
        links=TWO_LINKS,
    ),
    equation(
        "2.34",
        "derivative of E_p by phi of a link between two springs",
        r"\frac{\partial E_p}{\partial \varphi_s} "
        r"= k(-\varphi_{s-1} + 2\varphi_s - \varphi_{s+1})",
        lambda n: truth(n).spring_slopes[3:-1],
        over=lambda n: range(1, n - 1),
        links=THREE_LINKS,
        note="The range of s is not printed; between 2.33 and 2.35 it can only be 1 to n-2.",
    ),
    equation(
        "2.35",
        "derivative of E_p by phi of the last link",
        r"\frac{\partial E_p}{\partial \varphi_{n-1}} = k(\varphi_{n-1} - \varphi_{n-2})",
        lambda n: truth(n).spring_slopes[-1:],
        links=TWO_LINKS,
    ),
    Claim(
        "2.36",
        "derivative of E_p by x0",
        {READ: lambda n: [S.Zero]},
        lambda n: truth(n).spring_slopes[:1],
        printed=r"\frac{\partial E_p}{\partial x_0} = 0",
    ),
    Claim(
        "2.37",
        "derivative of E_p by y0",
        {READ: lambda n: [NOT_PRINTED]},
        lambda n: truth(n).spring_slopes[1:2],
        corrected=lambda n: [S.Zero],
        printed=r"\frac{\partial E_p}{\partial x_0} = 0",
        correction=r"\frac{\partial E_p}{\partial y_0} = 0",
        note="2.36, for x0, is printed a second time in place of the derivative by y0.",
        label=lambda n, at: "dE_p/dy0",
    ),
    lagrange_claim(
        "2.38",
        0,
        r"\frac{d}{dt} \left(\frac{\partial L}{\partial v_{x0}} \right) "
        r"= \frac{\partial E_k}{\partial x_0} - \frac{\partial E_p}{\partial x_0}",
        LOST_INDEX,
    ),
    lagrange_claim(
        "2.39",
        1,
        r"\frac{d}{dt} \left(\frac{\partial L}{\partial v_{y0}} \right) "
        r"= \frac{\partial E_k}{\partial y_0} - \frac{\partial E_p}{\partial y_0}",
        LOST_INDEX,
    ),
    lagrange_claim(
        "2.40",
        2,
        r"\frac{d}{dt} \left(\frac{\partial L}{\partial \omega_s} \right) "
        r"= \frac{\partial E_k}{\partial \varphi_s} - \frac{\partial E_p}{\partial \varphi_s}, "
        r"\quad s = 0, 1, 2, \dots, n-1",
        LOST_INDEX,
    ),
)
