"""Structures: their parameters, their expressions, and the names of their modules."""

from __future__ import annotations

from itertools import product

from rodgen.emit.targets import check_output
from rodgen.model.rod import BOUNDARIES, NONUNIFORM, STEADY
from rodgen.model.terms import CONTACTS, PARAMETERS, PLACES, TERMS, THESIS_TERMS
from rodgen.scene.structure import Structure
from rodgen.scene.term_texts import parse_terms
from tests.palette import ALL, ALONG
from tests.told import refused

DIFFERING = {one.name for way in NONUNIFORM.values() for one in way.parameters} | {
    one.name for one in STEADY.values()
}


def test_every_parameter_has_its_place_in_p_and_in_a_scene() -> None:
    key = {"distributed_follower": "@angle", "gravity": "@acceleration"}
    key |= {"foundation": "@through", "base": "@x+y+angle", "joint_friction": "@moment_per_length"}
    key |= dict.fromkeys(("fins", "nose", "axial_drag"), "@wind")
    everything = Structure(
        3, "clamped", terms=tuple(f"{x}{key.get(x, '')}" for x in (*ALL, "base"))
    )
    replaced = {"gravity", "joint_friction_moment"}
    others = DIFFERING | replaced | {one.name for term in CONTACTS for one in term.parameters}
    others |= {name for name, one in PARAMETERS.items() if one.by_height}
    assert (
        everything.parameters
        == tuple(name for name in PARAMETERS if name not in others)
        == (
            *("mass", "length", "bending_stiffness", "follower_force", "follower_angle"),
            *("gravity_x", "gravity_y", "internal_damping", "external_damping", "clamp_angle"),
            *("tip_force_x", "tip_force_y"),
            *("material_damping_time", "distributed_follower_angle", "foundation_angle"),
            "foundation_offset",
            *("support_angle", "drag_normal", "drag_tangential", "wind_x", "wind_y"),
            *("viscous_drag_normal", "viscous_drag_tangential"),
            *("viscous_drag_wind_x", "viscous_drag_wind_y", "moment_size"),
            *("base_x", "base_y", "base_angle"),
            *("joint_friction_per_length", "joint_friction_rate"),
            *("fins_normal_slope", "fins_area"),
            *("air_density", "air_wind_x", "air_wind_y", "air_stall_angle"),
            *("nose_normal_slope", "nose_area", "axial_drag_coefficient", "axial_drag_area"),
            *("fin_factor", "distributed_follower", "foundation_stiffness", "foundation_damping"),
            *(one.name for one in TERMS["supports"].parameters if one.is_array),
        )
    )  # modules, files and programs in C rely on the order
    computed = ("foundation_", "support_")
    given = {name for name in everything.parameters if not name.startswith(computed)}
    assert set(PLACES) == given | replaced
    assert len(set(PLACES.values())) == len(PLACES)
    for name, term in TERMS.items():
        assert name == term.name
        assert term.table == name.removesuffix("_load") + "s" * (term in CONTACTS)


def test_order_of_expressions_does_not_matter() -> None:
    pairs = (("tip_force_x", "t"), ("follower_force", "2 * t"))
    one, two = (Structure(3, terms=ALL, expressions=e) for e in (pairs, pairs[::-1]))
    assert one == two
    assert one.hash == two.hash
    wrong = {"internal_damping": ALL, "tip_force_x": THESIS_TERMS, "follower_force": ()}
    for name, terms in wrong.items():
        told = refused(Structure, 3, terms=tuple(terms), expressions=((name, "t"),))
        assert told[:2] == ("expressions", name)


NAMES = [(("numpy", "chain"), ""), (("numpy", "dense"), "_dense"), (("c", "chain"), "_c")]


def test_names_of_modules() -> None:
    structures = {
        Structure(20): "rod_free_n20",
        Structure(5, "pinned", terms=()): "rod_pinned_n5_conservative",
        Structure(5, "clamped", "lumped", ("tip_load",)): "rod_clamped_n5_tip_load_lumped",
        Structure(5, inertia="lumped"): "rod_free_n5_lumped",
        Structure(2, terms=ALONG): f"rod_free_n2_{'_'.join(ALONG)}",
    }
    for (structure, stem), (output, ending) in product(structures.items(), NAMES):
        assert structure.stem == structure.module_stem() == stem
        assert structure.module_stem(*output) == stem + ending


def test_modules_that_differ_in_an_expression_differ_in_name() -> None:
    for output, ending in NAMES:
        stems = set()
        for text in ("sin(t)", "cos(t)"):
            structure = Structure(5, expressions=(("follower_force", text),))
            stem = structure.module_stem(*output)
            assert stem == f"rod_free_n5{ending}_{structure.hash[:6]}"
            assert stem.isidentifier()
            stems.add(stem)
        assert len(stems) == 2


def test_modules_of_many_loads_have_names_that_files_can_have() -> None:
    """Of at most 255 letters, endings included."""
    one, two = (Structure(5, terms=(f"moment@{at}", *["moment"] * 99)) for at in (1, 2))
    for output, ending in NAMES:
        stem = one.module_stem(*output)
        assert stem.endswith(f"_and_84_more{ending}_{one.hash[:6]}")
        assert len(stem) < 200
        assert stem != two.module_stem(*output)


def test_a_load_that_is_nowhere_in_particular_has_no_place() -> None:
    for kind in ("internal_damping", "viscous_drag"):
        told = refused(Structure, 5, terms=(f"{kind}@2",))
        assert told == ("terms", f"{kind}@2", f"{kind}, which has no place")


def test_what_cannot_be_written_or_move_is_refused() -> None:
    for boundary, boundary_condition in BOUNDARIES.items():
        for links in (-3, 0, boundary_condition.min_links - 1):
            assert refused(Structure, links, boundary)[:2] == ("links", links)
        assert Structure(boundary_condition.min_links, boundary).stem.isidentifier()
    for target, form, field, value in (
        ("fortran", "chain", "target", "fortran"),
        ("numpy", "sparse", "form", "sparse"),
        ("c", "dense", "form", "dense"),
    ):
        assert refused(check_output, target, form)[:2] == (field, value)


def test_all_terms_are_those_of_the_thesis() -> None:
    assert parse_terms("all") == THESIS_TERMS == Structure(3).terms
    assert "tip_load" not in THESIS_TERMS
    assert parse_terms("tip_load, follower") == ("follower", "tip_load")
    assert parse_terms("tip_load") == ("tip_load",)
    names = ("tip_load", "gravity", "follower")
    given, turned = (Structure(3, "pinned", "lumped", terms) for terms in (names, names[::-1]))
    assert (given, given.hash) == (turned, turned.hash)
    told = refused(parse_terms, "tip")
    assert told[:2] == ("terms", "tip")
    assert all(term in told.allowed for term in TERMS)
