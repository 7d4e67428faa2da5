"""The site: `make docs` builds it into build/site, without reaching out."""

from __future__ import annotations

import logging
import os
import shutil
import sys
from pathlib import Path

from rodgen import __version__ as release  # noqa: F401  Sphinx reads it

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE / "site"), str(HERE.parent)]

from tests.cache import cache  # noqa: E402  of this repository, as that folder is

# What examples and notebooks compile is there for the tests of the pages, and the other way round.
os.environ.setdefault("RODGEN_CACHE", str(cache()))
# Sphinx reads no pages outside of its folder.
shutil.copytree(HERE.parent / "notebooks", HERE / "notebooks", dirs_exist_ok=True)
# Pages that an earlier build made of examples that are no longer there would be read again.
for made in (HERE / "examples").rglob("plot_*"):
    example = HERE / "gallery" / made.relative_to(HERE / "examples")
    if not example.with_name(f"{made.name.partition('.')[0]}.py").exists():
        made.unlink()
logging.getLogger("matplotlib.animation").setLevel(logging.ERROR)
logging.getLogger("traitlets").setLevel(logging.ERROR)

project, author, copyright = "rodgen", "The rodgen authors", "the rodgen authors"
extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.viewcode",
    "numpydoc",
    "sphinx_design",
    "sphinx_copybutton",
    "sphinx_gallery.gen_gallery",
    "formulas",
    "commands",
    "quantities",
    "rows",
    "headings",
    "names",
    "replays",
    "films",
    "pictures",
]
exclude_patterns = ["site", "conftest.py", "gallery", "examples/*/*.ipynb"]
smartquotes = False
myst_enable_extensions = ["dollarmath", "colon_fence", "deflist", "attrs_inline", "html_image"]
myst_heading_anchors = 4
html_math_renderer = "mathml"
nb_execution_mode = "cache"
nb_execution_timeout = 300
nb_execution_raise_on_error = True
nb_output_stderr = "remove"  # bars of progress
SECTIONS = ("motion", "stability", "cycles", "many", "trust")
sphinx_gallery_conf = {
    "examples_dirs": "gallery",
    "gallery_dirs": "examples",  # written anew by every build
    "subsection_order": [f"gallery/{one}" for one in SECTIONS],
    "within_subsection_order": "FileNameSortKey",
    "backreferences_dir": "examples/backreferences",
    "doc_module": ("rodgen",),
    "reference_url": {"rodgen": None},
    "matplotlib_animations": (True, "html5"),
    "reset_modules": ("matplotlib", "films.prepare"),
    "capture_repr": (),
    "abort_on_example_error": True,
    "show_memory": False,
    "write_computation_times": False,
    "download_all_examples": False,
}

autodoc_mock_imports = ["jax"]  # rodgen.jax is described where JAX is not installed, too
numpydoc_show_class_members = False
autodoc_typehints_format = "short"
autodoc_type_aliases = {"ArrayLike": "ArrayLike", "Array": "Array"}
python_maximum_signature_line_length = 88
autodoc_member_order = "bysource"
html_theme = "furo"
html_title = "rodgen"
html_static_path = ["static"]
html_css_files = ["rodgen.css"]
html_js_files = ["rodgen.js"]
