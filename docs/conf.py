"""Sphinx configuration: `sphinx-build -W -b html docs docs/_build/html`."""

from taskbuilder import __version__

project = "taskbuilder"
author = "The taskbuilder contributors"
release = __version__

extensions = ["myst_parser"]
exclude_patterns = ["_build", "generators"]

myst_enable_extensions = ["colon_fence", "deflist"]
myst_heading_anchors = 4

html_theme = "furo"
html_title = f"taskbuilder {release}"
html_static_path = ["_static"]
html_css_files = ["custom.css"]
html_copy_source = False
html_show_copyright = False
html_show_sphinx = False
