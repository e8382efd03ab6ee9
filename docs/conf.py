"""Sphinx configuration: `sphinx-build -W -b html docs docs/_build/html`."""

import sys
from pathlib import Path

from taskbuilder import __version__

sys.path.insert(0, str(Path(__file__).parent))

project = "taskbuilder"
author = "The taskbuilder contributors"
release = __version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "generators"]
exclude_patterns = ["_build", "generators"]

myst_enable_extensions = ["colon_fence", "deflist"]
myst_heading_anchors = 3

default_role = "code"  # what docstrings put in single backticks
autodoc_member_order = "bysource"
autodoc_preserve_defaults = True
autodoc_typehints = "none"  # docstrings say what matters; the source has the rest
napoleon_attr_annotations = False
napoleon_use_ivar = True
napoleon_use_rtype = False

html_theme = "furo"
html_title = f"taskbuilder {release}"
html_static_path = ["_static"]
html_css_files = ["custom.css"]
html_copy_source = False
html_show_copyright = False
html_show_sphinx = False
