"""Findings on a page: what is wrong, the lines it speaks of, and what its code means."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from taskbuilder.assets.codes import CODES as ASSET_CODES
from taskbuilder.diagnostics import CODES
from taskbuilder.errors import Finding
from taskbuilder.validate.formats.excerpt import Line, excerpt
from taskbuilder.validate.formats.markup import Html, element


def findings_list(findings: Sequence[Finding]) -> Html:
    """All findings, with the meaning of each code where it stands first."""
    return element("ol", _listed(findings), class_="findings")


def title_of(code: str) -> tuple[str, str]:
    """What a code stands for in a few words, and its meaning; both "" for an unknown one."""
    if code in CODES:
        return CODES[code].title, CODES[code].meaning
    return ASSET_CODES.get(code, ("", ""))


def _listed(findings: Sequence[Finding]) -> Iterator[Html]:
    explained: set[str] = set()
    for finding in findings:
        title, meaning = title_of(finding.code)
        first = bool(meaning) and finding.code not in explained
        explained.add(finding.code)
        yield element(
            "li",
            element("p", _badge(finding), " ", element("b", title), class_="code"),
            element("p", _subject(finding), finding.message, class_="message"),
            _place(finding),
            element("p", meaning, class_="meaning") if first else None,
            class_=finding.severity,
        )


def _badge(finding: Finding) -> Html:
    return element("span", f"{finding.severity} {finding.code}", class_="badge")


def _subject(finding: Finding) -> Html | None:
    return element("code", finding.path) if finding.path else None


def _place(finding: Finding) -> Html | None:
    if finding.location is None:
        return None
    lines = excerpt(finding.location)
    where = element("p", str(finding.location), class_="where")
    if not lines:
        return element("div", where, class_="excerpt")
    width = len(str(lines[-1].number))
    code = element("pre", element("code", [_line(line, width) for line in lines]), tabindex=0)
    return element("div", where, code, class_="excerpt")


def _line(line: Line, width: int) -> Html:
    marked = element("mark", line.marked) if line.marked else None
    return element(
        "span",
        element("i", f"{line.number:>{width}}"),
        line.before,
        marked,
        line.after,
        "\n",
        class_="line here" if line.spoken_of else "line",
    )
