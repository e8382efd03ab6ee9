"""Pages as HTML documents: the templates and the style sheet beside this file, filled in."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

from jinja2 import Environment, PackageLoader, StrictUndefined

from taskbuilder import __version__
from taskbuilder.validate.formats.cases import why_skipped
from taskbuilder.validate.formats.words import counted, duration, measured, number, printable
from taskbuilder.validate.html.chart import charts
from taskbuilder.validate.html.content import (
    data_uri,
    explained,
    found_wrong,
    limit,
    orders,
    with_units,
)
from taskbuilder.validate.html.page import Page

_FILTERS = (
    *(counted, data_uri, duration, explained, found_wrong, limit, measured, number, orders),
    *(why_skipped, with_units),
)


def task_page(page: Page) -> str:
    """The report of one task as an HTML document."""
    report = page.report
    probes = [probe for family in report.families for probe in family.probes]
    return _document(
        "task.html.j2", page=page, report=report, pictures=page.pictures, charts=charts(probes)
    )


def index_page(pages: Sequence[tuple[str, Page]]) -> str:
    """A page that lists the reports of several tasks, by the names of their files."""
    return _document("index.html.j2", pages=pages)


def _document(template: str, **content: object) -> str:
    text = _environment().get_template(template).render(version=__version__, **content)
    return printable(text)  # a name may have what no document can hold


@cache
def _environment() -> Environment:
    """Where text becomes markup nowhere but in templates, and a misspelt name is an error."""
    made = Environment(
        loader=PackageLoader("taskbuilder.validate.html", "."),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    made.filters |= {filter_.__name__: filter_ for filter_ in _FILTERS}
    return made
