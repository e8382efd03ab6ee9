"""Sphinx configuration: `sphinx-build -W -b html docs docs/_build/html`."""

import os
import sys
from pathlib import Path
from urllib.parse import urlparse

from taskbuilder import __version__

sys.path.insert(0, str(Path(__file__).parent))  # the generators beside this file

project = "taskbuilder"
author = "The taskbuilder contributors"
release = __version__

extensions = [
    "myst_parser",
    "sphinx_design",
    "sphinx_copybutton",
    "sphinxext.opengraph",
    "notfound.extension",
]
exclude_patterns = ["_build", "generators"]

myst_enable_extensions = ["colon_fence", "deflist"]
myst_heading_anchors = 4

html_theme = "furo"
html_title = f"taskbuilder {release}"
html_static_path = ["_static"]
html_css_files = ["custom.css"]
html_js_files = [("gallery.js", {"defer": "defer"})]
html_copy_source = False
html_use_index = False  # the site has no index entries, and an empty page helps nobody
html_baseurl = os.environ.get("READTHEDOCS_CANONICAL_URL") or os.environ.get("SITE_URL", "")
html_show_copyright = False
html_show_sphinx = False

copybutton_exclude = ".linenos, .gp, .go"  # prompts and output are not copied
ogp_site_url = html_baseurl
ogp_use_first_image = True
ogp_enable_meta_description = True
notfound_urls_prefix = f"{urlparse(html_baseurl).path.rstrip('/')}/"


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
