"""Write what is generated: `cd docs && python -m generators`."""

from __future__ import annotations

from generators import fill, pages, tasks
from taskbuilder._library import folder
from taskbuilder.schema.index import index_text
from taskbuilder.schema.summaries import INDEX
from taskbuilder.versions import VERSIONS, versions_text

library = folder("tasks")
(library / INDEX).write_text(index_text(library), encoding="utf-8")
(library / VERSIONS).write_text(versions_text(library), encoding="utf-8")
for page, text in tasks.missing_pages():
    page.write_text(text, encoding="utf-8")
for page in pages():
    try:
        text = fill(page.read_text(encoding="utf-8"))
    except (LookupError, ValueError) as error:
        raise SystemExit(f"{page.name}: {error}") from None
    page.write_text(text, encoding="utf-8")
