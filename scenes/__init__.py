"""Scenes and studies in TOML, to start from; `rodgen.scene.examples` reads them."""
