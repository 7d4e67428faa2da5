"""The site: `make docs` builds it into build/site, without reaching out."""

from __future__ import annotations

import logging
import shutil
import sys
from pathlib import Path

from rodgen import __version__ as release  # noqa: F401  Sphinx reads it

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "site"))
# Sphinx reads no pages outside of its folder.
shutil.copytree(HERE.parent / "notebooks", HERE / "notebooks", dirs_exist_ok=True)
logging.getLogger("matplotlib.animation").setLevel(logging.ERROR)
logging.getLogger("traitlets").setLevel(logging.ERROR)

project, author, copyright = "rodgen", "The rodgen authors", "the rodgen authors"
extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "numpydoc",
    "sphinx_design",
    "sphinx_copybutton",
    "sphinx_gallery.gen_gallery",
    "formulas",
    "commands",
    "headings",
    "replays",
    "films",
]
exclude_patterns = ["site", "conftest.py", "gallery", "examples/*.ipynb"]
smartquotes = False
myst_enable_extensions = ["dollarmath", "colon_fence", "deflist", "attrs_inline", "html_image"]
myst_heading_anchors = 4
html_math_renderer = "mathml"
nb_execution_mode = "cache"
nb_execution_timeout = 300
nb_execution_raise_on_error = True
nb_output_stderr = "remove"  # bars of progress
sphinx_gallery_conf = {
    "examples_dirs": "gallery",
    "gallery_dirs": "examples",  # written anew by every build
    "matplotlib_animations": (True, "html5"),
    "reset_modules": ("matplotlib", "films.encode"),
    "capture_repr": (),
    "abort_on_example_error": True,
    "show_memory": False,
    "write_computation_times": False,
    "download_all_examples": False,
}

autodoc_mock_imports = ["jax"]  # rodgen.jax is described where JAX is not installed, too
numpydoc_show_class_members = False
autodoc_typehints = "description"
autodoc_member_order = "bysource"
html_theme = "furo"
html_title = "rodgen"
html_static_path = ["static"]
html_css_files = ["rodgen.css"]
html_js_files = ["rodgen.js"]
