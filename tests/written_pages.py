"""The pages of the documentation, as people wrote them."""

from __future__ import annotations

import re
from pathlib import Path

DOCS = Path(__file__).resolve().parents[1] / "docs"


def written(name: str) -> str:
    """The text of a page without what is generated into it."""
    text = (DOCS / name).read_text(encoding="utf-8")
    return re.sub(r"^<!-- generated: .*?^<!-- end -->$", "", text, flags=re.MULTILINE | re.DOTALL)
