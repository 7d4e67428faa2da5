"""What is modelled: scenes from TOML, their structure, and the grammar of expressions."""

from rodgen.scene.errors import SceneError
from rodgen.scene.scene import Scene
from rodgen.scene.structure import Structure

__all__ = ["Scene", "SceneError", "Structure"]
