"""Read YAML safely and remember where every key and value stood.

The text becomes plain data (dicts, tuples, strings, numbers, booleans, None) and two tables of
marks. Limits on size, depth and aliases apply while events arrive, before anything is built, so
that a hostile file costs no memory. Numbers and booleans follow YAML 1.2's core schema: ``1e-3``
is a number, ``off`` is a string.
"""

from __future__ import annotations

import re
import stat
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml

from taskbuilder.errors import FileError, Finding, Location

MAX_BYTES = 256 * 1024
MAX_DEPTH = 24
MAX_NODES = 20_000
MAX_DIGITS = 100

Path_ = tuple[str | int, ...]
"""Where a value is in a file: keys and list indices from the top."""

# libyaml's parser where PyYAML was built with it: ten times as fast, same events and marks.
LOADER: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)

_NUMBERS: tuple[tuple[re.Pattern[str], Callable[[str], int | float]], ...] = (
    (re.compile(r"[-+]?[0-9]+"), int),
    (re.compile(r"0x[0-9a-fA-F]+|0o[0-7]+"), lambda text: int(text, 0)),
    (re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?"), float),
)
_SPECIAL: dict[str, bool | float | None] = {
    **dict.fromkeys(("", "~", "null", "Null", "NULL")),
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
    **dict.fromkeys((".inf", "+.inf", ".Inf", "+.Inf", ".INF", "+.INF"), float("inf")),
    **dict.fromkeys(("-.inf", "-.Inf", "-.INF"), float("-inf")),
    **dict.fromkeys((".nan", ".NaN", ".NAN"), float("nan")),
}


@dataclass(frozen=True)
class Source:
    """A YAML file as plain data, with the place of every key and value.

    Attributes:
        file: The file, as it was given.
        data: The top-level mapping.
        values: Path of a value -> its line and column.
        keys: Path of a mapping entry -> line and column of its key.
        findings: What is wrong without keeping the rest from being read (duplicate keys, tags).
        entries_of: Section and name of a thing that an entry of another name stands for -> section
            and name of that entry; they stand below ``scene``.
    """

    file: Path
    data: Mapping[str, Any]
    values: Mapping[Path_, tuple[int, int]]
    keys: Mapping[Path_, tuple[int, int]]
    findings: tuple[Finding, ...] = ()
    entries_of: Mapping[Path_, Path_] = field(default_factory=dict)

    def written(self, path: Path_) -> Path_:
        """Where in the file a path is written: for ``scene.objects.cubes_3``, at its group."""
        entry = self.entries_of.get(path[1:3]) if path[:1] == ("scene",) else None
        return path if entry is None else ("scene", *entry, *path[3:])

    def locate(self, path: Path_, *, key: bool = False) -> Location:
        """The place of a value (or of its key), or of its nearest ancestor that exists."""
        path = self.written(path)
        for length in range(len(path), 0, -1):
            ancestor = path[:length]
            wanted = self.keys if key or length < len(path) else self.values
            mark = wanted.get(ancestor) or self.values.get(ancestor)
            if mark:
                return Location(self.file, *mark)
        return Location(self.file, 1, 1)

    def get(self, *path: str | int) -> Any:
        """The value at a path, or None where the file holds nothing of that shape there."""
        value: Any = self.data
        for step in path:
            held = dict(enumerate(value)) if isinstance(value, tuple) else value
            if not isinstance(held, dict) or step not in held:
                return None
            value = held[step]
        return value

    def entries(self, *path: str | int) -> Iterator[tuple[str, Any]]:
        """The entries of the mapping at a path; none where there is no mapping."""
        value = self.get(*path)
        if isinstance(value, dict):
            yield from value.items()


def read_source(file: Path) -> Source:
    """Read a YAML file whose top level is a mapping.

    Raises:
        FileError: The file cannot be read, is no YAML, or breaks a limit.
    """
    return _Reader(file).read(_read_text(file))


def is_text(plain: str) -> bool:
    """Whether a scalar without quotation marks is read as text."""
    return plain not in _SPECIAL and not any(form.fullmatch(plain) for form, _ in _NUMBERS)


def dotted(path: Path_) -> str:
    """A path as people write it: ``expert[2].left.grasp``."""
    text = ""
    for step in path:
        text += f"[{step}]" if isinstance(step, int) else f".{step}" if text else step
    return text


def _read_text(file: Path) -> str:
    def refuse(code: str, message: str, line: int = 0, column: int = 0) -> FileError:
        return FileError([Finding(code, message, location=Location(file, line, column))])

    try:
        status = file.stat()
        if stat.S_ISDIR(status.st_mode):
            raise refuse("TB001", "this is a folder; name the YAML file in it")
        if not stat.S_ISREG(status.st_mode):
            raise refuse("TB001", "this is no plain file")
        if status.st_size > MAX_BYTES:
            raise refuse("TB006", f"{status.st_size:,} bytes; at most {MAX_BYTES:,} are read")
        raw = file.read_bytes()
    except FileNotFoundError:
        raise refuse("TB001", "there is no such file") from None
    except ValueError:
        raise refuse("TB001", "cannot be read: its path contains a null character") from None
    except OSError as error:
        raise refuse("TB001", f"cannot be read: {error.strerror or error}") from None
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = raw.count(b"\n", 0, error.start) + 1
        message = f"byte 0x{raw[error.start]:02x} is not UTF-8; save the file as UTF-8"
        raise refuse("TB002", message, line, 1) from None


@dataclass(slots=True)
class _Node:
    """A value being read: a mapping holds (key mark, node) pairs, a sequence holds nodes."""

    mark: tuple[int, int]
    content: Any
    size: int = 1
    height: int = 1


@dataclass
class _Reader:
    """Turns one file's events into a `Source`."""

    file: Path
    findings: list[Finding] = field(default_factory=list)
    anchors: dict[str, _Node] = field(default_factory=dict)
    nodes: int = 0

    def read(self, text: str) -> Source:
        events = self._events(text)
        root = self._document(events)
        if root is None or root.content is None:
            raise self._fatal("TB007", "the file is empty; a task or robot file is a mapping", None)
        if not isinstance(root.content, dict):
            raise self._fatal("TB007", "the top level must be a mapping of keys", root.mark)
        values: dict[Path_, tuple[int, int]] = {}
        keys: dict[Path_, tuple[int, int]] = {}
        data = _flatten(root, (), values, keys)
        return Source(self.file, data, values, keys, tuple(self.findings))

    def _finding(self, code: str, message: str, mark: tuple[int, int] | None) -> Finding:
        return Finding(code, message, location=Location(self.file, *(mark or ())))

    def _fatal(self, code: str, message: str, mark: tuple[int, int] | None) -> FileError:
        return FileError([*self.findings, self._finding(code, message, mark)])

    def _events(self, text: str) -> Iterator[Any]:
        try:
            yield from yaml.parse(text, Loader=LOADER)
        except yaml.MarkedYAMLError as error:
            raise self._fatal("TB003", *_syntax_problem(error, text)) from None
        except yaml.YAMLError as error:
            bad = re.search(
                r"[^\t\n\r\x20-\x7e\x85\xa0-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]", text
            )
            where = text[: bad.start()] if bad else ""
            mark = (where.count("\n") + 1, len(where) - where.rfind("\n")) if bad else None
            reason = f"control character {bad.group()!r}" if bad else str(error).splitlines()[0]
            raise self._fatal("TB003", f"not valid YAML: {reason}", mark) from None

    def _document(self, events: Iterator[Any]) -> _Node | None:
        root = None
        for event in events:
            if isinstance(event, yaml.DocumentStartEvent) and root is not None:
                raise self._fatal(
                    "TB003", "a second document begins; keep one in a file", _mark(event)
                )
            if isinstance(event, yaml.NodeEvent):
                root = self._node(event, events, 1)
        return root

    def _node(self, event: Any, events: Iterator[Any], depth: int) -> _Node:
        mark = _mark(event)
        if depth > MAX_DEPTH:
            raise self._fatal("TB006", f"nested deeper than {MAX_DEPTH} levels", mark)
        if isinstance(event, yaml.AliasEvent):
            return self._alias(event, mark, depth)
        self._check_tag(event, mark)
        self._count(1, mark)
        if isinstance(event, yaml.ScalarEvent):
            plain = event.implicit[0] or (event.tag and not event.style)
            node = _Node(mark, self._scalar(event.value, mark) if plain else event.value)
        elif isinstance(event, yaml.SequenceStartEvent):
            items = []
            while not isinstance(inner := next(events), yaml.SequenceEndEvent):
                items.append(self._node(inner, events, depth + 1))
            node = _branch(mark, items, items)
        else:
            node = self._mapping(mark, events, depth)
        if event.anchor is not None:
            self.anchors[event.anchor] = node
        return node

    def _mapping(self, mark: tuple[int, int], events: Iterator[Any], depth: int) -> _Node:
        entries: dict[str, tuple[tuple[int, int], _Node]] = {}
        while not isinstance(event := next(events), yaml.MappingEndEvent):
            key_mark = _mark(event)
            if not isinstance(event, yaml.ScalarEvent):
                raise self._fatal("TB003", "a key must be a plain name", key_mark)
            self._check_tag(event, key_mark)
            self._count(1, key_mark)
            node = self._node(next(events), events, depth + 1)
            key = event.value
            if key == "<<" and event.implicit[0]:
                message = (
                    "merge keys belong to YAML 1.1; write the keys out, or repeat one by *alias"
                )
                raise self._fatal("TB005", message, key_mark)
            if key in entries:
                line = entries[key][0][0]
                message = f'the key "{key}" stands here for the second time; it is on line {line}'
                self.findings.append(self._finding("TB004", message, key_mark))
            else:
                entries[key] = (key_mark, node)
        return _branch(mark, entries, [node for _, node in entries.values()])

    def _check_tag(self, event: Any, mark: tuple[int, int]) -> None:
        if event.tag is not None:
            message = f'the tag "{event.tag}" is not read; write the plain value'
            self.findings.append(self._finding("TB005", message, mark))

    def _alias(self, event: Any, mark: tuple[int, int], depth: int) -> _Node:
        node = self.anchors.get(event.anchor)
        if node is None:
            message = f'no anchor "&{event.anchor}" is complete before this alias'
            raise self._fatal("TB006", message, mark)
        self._count(node.size, mark)
        if depth + node.height - 1 > MAX_DEPTH:
            raise self._fatal("TB006", f"nested deeper than {MAX_DEPTH} levels", mark)
        return _Node(mark, node.content, node.size, node.height)

    def _count(self, nodes: int, mark: tuple[int, int]) -> None:
        self.nodes += nodes
        if self.nodes > MAX_NODES:
            message = f"more than {MAX_NODES:,} values once aliases are written out"
            raise self._fatal("TB006", message, mark)

    def _scalar(self, text: str, mark: tuple[int, int]) -> Any:
        if text in _SPECIAL:
            return _SPECIAL[text]
        number = next((read for form, read in _NUMBERS if form.fullmatch(text)), None)
        if number is None:
            return text
        if len(text) > MAX_DIGITS:
            raise self._fatal("TB104", f"a number of over {MAX_DIGITS} digits", mark)
        return number(text)


def _branch(mark: tuple[int, int], content: Any, children: list[_Node]) -> _Node:
    size = 1 + sum(1 + child.size for child in children)
    return _Node(mark, content, size, 1 + max((child.height for child in children), default=0))


def _syntax_problem(error: Any, text: str) -> tuple[str, tuple[int, int] | None]:
    """What the parser stumbled over and where, so that the place is that of the mistake."""
    place, start = error.problem_mark or error.context_mark, error.context_mark
    what = ", ".join(part for part in (error.context, error.problem) if part)
    if place and text[place.index : place.index + 1] == "\t":
        what = "a tab; indent by spaces"
    elif error.problem == "did not find expected key" and start and place:
        what = f"the indentation is not that of what begins on line {start.line + 1}"
    elif error.problem == "mapping values are not allowed in this context":
        what = "a ': ' within a text; put the text in quotation marks"
    elif start and "simple key" in what:  # noticed only on the next line
        place, what = start, "a key without ': ' after it"
    elif start and place and start.line < place.line:
        what += f"; it begins on line {start.line + 1}"
    return f"not valid YAML: {what}", (place.line + 1, place.column + 1) if place else None


def _mark(event: Any) -> tuple[int, int]:
    return (event.start_mark.line + 1, event.start_mark.column + 1)


def _flatten(
    node: _Node,
    path: Path_,
    values: dict[Path_, tuple[int, int]],
    keys: dict[Path_, tuple[int, int]],
) -> Any:
    """Plain data of a node; fills the tables of marks on the way."""
    values[path] = node.mark
    if isinstance(node.content, dict):
        for key, (mark, _) in node.content.items():
            keys[(*path, key)] = mark
        return {
            key: _flatten(child, (*path, key), values, keys)
            for key, (_, child) in node.content.items()
        }
    if isinstance(node.content, list):
        return tuple(
            _flatten(child, (*path, index), values, keys)
            for index, child in enumerate(node.content)
        )
    return node.content
