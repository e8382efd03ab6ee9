"""Sphinx configuration: `sphinx-build -W -b html docs docs/_build/html`."""

import sys
from pathlib import Path

from taskbuilder import __version__

sys.path.insert(0, str(Path(__file__).parent))  # the generators beside this file

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


def setup(app):
    """Write the site as plain texts, too, beside its pages."""
    app.connect("build-finished", _write_texts)


def _write_texts(app, error):
    """Write `llms.txt` and `llms-full.txt` where pages have been built."""
    from generators import texts

    if error is None and app.builder.name == "html":
        docs, built = Path(app.srcdir), Path(app.outdir)
        (built / "llms.txt").write_text(texts.index(docs), encoding="utf-8")
        (built / "llms-full.txt").write_text(texts.whole(docs), encoding="utf-8")
