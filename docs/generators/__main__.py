"""Write what is generated: `cd docs && python -m generators`."""

from __future__ import annotations

from generators import fill, pages
from taskbuilder._library import folder
from taskbuilder.schema.summaries import INDEX, index_text

for page in pages():
    text = page.read_text(encoding="utf-8")
    page.write_text(fill(text), encoding="utf-8")
tasks = folder("tasks")
(tasks / INDEX).write_text(index_text(tasks), encoding="utf-8")
