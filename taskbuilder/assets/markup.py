"""XML with the place of every element, and without the parts of XML that robots do not need."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from xml.parsers import expat  # never given a file with a document type, so it expands nothing

from taskbuilder.assets import codes
from taskbuilder.errors import FileError, Finding, Location

MAX_BYTES = 2 * 2**20
_MAX_DEPTH = 32
# Bullet reads a file in lines of at most 8192 characters and cuts longer ones.
_MAX_LINE = 8_000
# As xml.sax.saxutils does, which imports a network stack.
_ESCAPES = str.maketrans(
    {"&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;", "\n": "&#10;", "\t": "&#9;"}
)


@dataclass(frozen=True, slots=True)
class Element:
    """An XML element. Text means nothing in a URDF, and is kept only where it is asked for."""

    tag: str
    attributes: dict[str, str]
    line: int
    column: int
    children: tuple[Element, ...] = field(default=())
    text: str = ""

    def all(self, tag: str) -> Iterator[Element]:
        """The children of a kind, in file order."""
        return (child for child in self.children if child.tag == tag)

    def first(self, tag: str) -> Element | None:
        """The first child of a kind, which is the one that the physics engine reads."""
        return next(self.all(tag), None)

    def get(self, attribute: str) -> str | None:
        """The value of an attribute, or None if it is absent."""
        return self.attributes.get(attribute)

    def with_attributes(self, **changed: str) -> Element:
        """The same element with some attributes set."""
        return replace(self, attributes={**self.attributes, **changed})

    def with_children(self, children: tuple[Element, ...]) -> Element:
        """The same element around other children."""
        return replace(self, children=children)


class _Refused(Exception):  # noqa: N818 - not an error of ours, only the way out of expat
    """The document holds something that is not read."""


class _Builder:
    """Builds the tree from expat's events."""

    def __init__(self, *, text: bool) -> None:
        self.root: Element | None = None
        self.parser = expat.ParserCreate()
        self.parser.StartElementHandler = self._start
        self.parser.EndElementHandler = self._end
        self.parser.StartDoctypeDeclHandler = self._refuse_doctype
        if text:
            self.parser.CharacterDataHandler = self._say
        self._open: list[tuple[Element, list[Element]]] = []
        self._said: list[list[str]] = []

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        if len(self._open) >= _MAX_DEPTH:
            raise _Refused(f"elements are nested more than {_MAX_DEPTH} deep; a URDF needs six")
        line, column = self.parser.CurrentLineNumber, self.parser.CurrentColumnNumber + 1
        self._open.append((Element(tag, attributes, line, column), []))
        self._said.append([])

    def _say(self, data: str) -> None:
        if self._said:
            self._said[-1].append(data)

    def _end(self, _tag: str) -> None:
        element, children = self._open.pop()
        said = "".join(self._said.pop()).strip()
        element = replace(element, children=tuple(children), text=said)
        if self._open:
            self._open[-1][1].append(element)
        else:
            self.root = element

    def _refuse_doctype(self, *_: object) -> None:
        raise _Refused("a document type declaration is not read; delete the <!DOCTYPE …> line")


def parse(path: Path, data: bytes, *, lines: bool = True, text: bool = False) -> Element:
    """The root element of an XML file.

    Args:
        path: The file that findings name.
        data: Its content.
        lines: Whether to refuse lines that the physics engine would cut.
        text: Whether to keep the text of elements.

    Raises:
        FileError: The file is not well-formed, or holds what no robot description needs.
    """
    if lines:
        _require_short_lines(path, data)
    builder = _Builder(text=text)
    try:
        builder.parser.Parse(data, True)
    except expat.ExpatError as error:
        message = f"not well-formed XML: {expat.ErrorString(error.code)}; mend the tags here"
        raise _refusal(path, message, error.lineno, error.offset + 1) from error
    except (_Refused, ValueError, LookupError) as error:  # the last two: an unknown encoding
        parser = builder.parser
        place = (parser.CurrentLineNumber, parser.CurrentColumnNumber + 1)
        raise _refusal(path, str(error), *place) from error
    if builder.root is None:
        raise _refusal(path, "the document is empty; write a <robot> element", 1, 1)
    return builder.root


def serialized(root: Element) -> str:
    """The XML text of an element, one tag a line, so that no line grows long."""
    return '<?xml version="1.0"?>\n' + "\n".join(_lines(root, 0)) + "\n"


def _lines(element: Element, depth: int) -> Iterator[str]:
    indent = "  " * depth
    opening = "".join(
        f' {name}="{text.translate(_ESCAPES)}"' for name, text in element.attributes.items()
    )
    if not element.children:
        yield f"{indent}<{element.tag}{opening}/>"
        return
    yield f"{indent}<{element.tag}{opening}>"
    for child in element.children:
        yield from _lines(child, depth + 1)
    yield f"{indent}</{element.tag}>"


def _require_short_lines(path: Path, data: bytes) -> None:
    for number, line in enumerate(data.splitlines(), start=1):
        if len(line) > _MAX_LINE:
            message = f"the line has {len(line)} characters; break it below {_MAX_LINE}"
            raise _refusal(path, message, number, _MAX_LINE)


def _refusal(path: Path, message: str, line: int, column: int) -> FileError:
    return FileError([Finding(codes.XML, message, "", Location(path, line, column))])
