"""Scenes from TOML, their structure, and the grammar of expressions."""

from rodgen.scene.scene import Scene
from rodgen.scene.structure import Structure
