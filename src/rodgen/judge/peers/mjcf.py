"""A scene as a model of MuJoCo, in its XML."""

from __future__ import annotations

from math import cos, sin

import rodgen
from rodgen.judge.peers.tree import Tree

# The names of the actuators are those of the parameters that drive them.
ACTUATORS = ("follower_force", "tip_force_x", "tip_force_y")


def mjcf(scene: rodgen.Scene, option: str = "") -> str:
    """The model; option: attributes of its option, the integrator say.

    The thrust acts at a site on the tail, with which MuJoCo turns it; the dead force at the tail in
    directions of a site of the world.
    """
    tree = Tree.of(scene)
    x, y = tree.base
    sliders = '<joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0"/>'
    before = f'<body pos="{x!r} {y!r} 0">{sliders if tree.translates else ""}'
    bodies = "".join(
        (f'<body pos="{tree.length!r} 0 0">' if i else before) + _hinge(tree, i) + _inertial(tree)
        for i in range(tree.links)
    )
    ends = f'<site name="tail" pos="{tree.length!r} 0 0"/>{"</body>" * tree.links}'
    flags = '<flag contact="disable" constraint="disable"/>'
    return f"""<mujoco>
        <compiler angle="radian" boundmass="0" boundinertia="0"/>
        <size memory="256M"/>
        <option gravity="0 {-tree.gravity!r} 0" {option}>{flags}</option>
        <worldbody><site name="world"/>{bodies}{ends}</worldbody>
        <actuator>{_actuators(scene)}</actuator>
    </mujoco>"""


def _hinge(tree: Tree, i: int) -> str:
    rest = f'springref="{tree.rest!r}"' if i == 0 else ""
    spring = f'stiffness="{tree.stiffness[i]!r}" damping="{tree.damping[i]!r}"'
    return f'<joint type="hinge" axis="0 0 1" {spring} {rest}/>'


def _inertial(tree: Tree) -> str:
    J = tree.inertia
    middle = f'pos="{tree.length / 2!r} 0 0"'
    return f'<inertial {middle} mass="{tree.mass!r}" diaginertia="{J!r} {J!r} {J!r}"/>'


def _actuators(scene: rodgen.Scene) -> str:
    nu = scene.parameters.get("follower_angle", 0.0)
    gears = {
        "follower_force": f'gear="{-cos(nu)!r} {-sin(nu)!r} 0 0 0 0"',
        "tip_force_x": 'refsite="world" gear="1 0 0 0 0 0"',
        "tip_force_y": 'refsite="world" gear="0 1 0 0 0 0"',
    }
    return "".join(f'<general site="tail" {gears[name]}/>' for name in driven(scene))


def driven(scene: rodgen.Scene) -> list[str]:
    """The parameters that the actuators follow, in their order."""
    return [name for name in ACTUATORS if name in scene.loads.parameters]
