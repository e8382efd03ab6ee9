"""Everything that has a name in files, descriptions and findings, by that name."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, get_args, get_type_hints

from pydantic import BaseModel

from taskbuilder import description
from taskbuilder.errors import UnknownNameError
from taskbuilder.reference import codes, extensions, keys, vocabulary
from taskbuilder.reference.meanings import DRAWN
from taskbuilder.reference.python import prose, signature
from taskbuilder.schema.order import ONLY_WITH, VERBS
from taskbuilder.wording import suggestion

_STAGES = ("Order", "Together", "Wait", "Repeat")


@dataclass(frozen=True)
class Entry:
    """What the reference says under a name.

    Attributes:
        name: The whole name, such as ``scene.objects.NAME.place``.
        kind: What it is, such as ``key of task files``.
        text: Markdown.
        keys: Of a key that holds others: a line each, as `taskbuilder.reference.keys.HEAD`.
    """

    name: str
    kind: str
    text: str
    keys: Sequence[Sequence[str]] = ()


def explain(name: str, load: extensions.Loader) -> tuple[Entry, ...]:
    """What the reference says of a name: of a path of keys, its end will do.

    Args:
        name: The name.
        load: Imports parts of other packages; see `taskbuilder.reference.extensions.described`.

    Raises:
        UnknownNameError: It says nothing.
    """
    own = tuple(entry for short, entry in _entries() if _ends(short, name))
    found = (*own, *_foreign(name, load))
    if not found:
        known = [part.name for part in extensions.declared()]
        known += [short.replace(".NAME", "").removeprefix("scene.") for short, _ in _entries()]
        known += [short.rpartition(".")[2] for short, _ in _entries()]
        sorts = "name a finding's code, a condition, a verb, a channel, or a path of keys"
        raise UnknownNameError(f'no entry "{name}"; {suggestion(name, known, otherwise=sorts)}')
    return found


def _ends(short: str, name: str) -> bool:
    return f".{_plain(short)}".endswith(f".{_plain(name)}")


def _foreign(name: str, load: extensions.Loader) -> Iterator[Entry]:
    """What other packages add under a name; only what has this name is imported."""
    for part in extensions.declared():
        if _ends(part.name, name):
            text = extensions.described(part, load)
            yield Entry(part.name, f"{part.noun} of {part.package}", text)
    if re.fullmatch(r"[a-z]{2,5}\d{3}", _plain(name)) and not name.upper().startswith("TB"):
        for code, package, text in extensions.codes():
            if _ends(code, name):
                yield Entry(code, f"finding of {package}", text)


def _plain(name: str) -> str:
    """Names of things and upper case do not count."""
    return name.replace(".NAME", "").lower()


@cache
def _entries() -> tuple[tuple[str, Entry], ...]:
    every = (*_codes(), *_public(), *_attributes(), *_drawn(), *_orders(), *_channels(), *_files())
    return tuple((entry.name, entry) for entry in every)


def _codes() -> Iterator[Entry]:
    for code in codes.known():
        yield Entry(code, "finding", codes.entry(code))


def _public() -> Iterator[Entry]:
    for name in description.__all__:
        thing = getattr(description, name)
        if name in vocabulary.named():
            yield Entry(name, "annotation of names", f"A name of {vocabulary.named()[name]}.")
        elif callable(thing):
            call = _one_line(f"{name}{signature(thing)}")
            about = prose(inspect.getdoc(thing) or "")
            names = [kind for kind in vocabulary.named() if kind in call]
            told = "\n".join(f"- {kind}: {vocabulary.named()[kind]}" for kind in names)
            yield Entry(name, _kind(thing), "\n\n".join(filter(None, (f"`{call}`", about, told))))


def _one_line(call: str) -> str:
    return re.sub(r",? \)", ")", " ".join(call.split())).replace("( ", "(")


def _attributes() -> Iterator[Entry]:
    """What a description declares, from its docstring."""
    told = inspect.getdoc(description.Description) or ""
    for name, meaning in re.findall(r"^    (\w+): (.+)$", told, re.MULTILINE):
        yield Entry(f"Description.{name}", "attribute of a description", meaning)


def _drawn() -> Iterator[Entry]:
    """What can be drawn for robots; what can be drawn for other things is a key of theirs."""
    for name, (value, meaning) in DRAWN.items():
        yield Entry(f"randomize.NAME.{name}", "quantity of a robot", _told(value, "", meaning))


def _kind(thing: object) -> str:
    bases = (base for base in vocabulary.BASES if vocabulary.is_a(thing, base))
    return f"{next(bases, 'name').lower()} of descriptions"


def _orders() -> Iterator[Entry]:
    for model in _STAGES:
        for key, value, default, meaning in keys.rows(model):
            verb = key.strip("`") in VERBS
            kind = "verb of an expert's orders" if verb else f"key of an expert's {model.lower()}"
            text = _told(value, "" if verb else default, meaning)
            goes_with = _with(key.strip("`")) if verb and model == "Order" else ()
            yield Entry(f"expert.{key.strip('`')}", kind, text, goes_with)


def _with(verb: str) -> Sequence[Sequence[str]]:
    """The keys that an order with this verb may have, a line each."""
    return [row for row in keys.rows("Order") if verb in ONLY_WITH.get(row[0].strip("`"), ())]


def _channels() -> Iterator[Entry]:
    for subject, quantity, meaning in vocabulary.quantities():
        whole = quantity if subject == "none" else f"SUBJECT.{quantity}"
        of = "" if subject == "none" else f" (subject: {subject})"
        yield Entry(whole, "observation channel", f"{meaning[:1].upper()}{meaning[1:]}{of}.")


def _files() -> Iterator[Entry]:
    yield from _keys("TaskSpec", "", "key of task files")
    yield from _keys("RobotSpec", "", "key of robot.yaml")
    yield from _keys("ObjectFileSpec", "", "key of object.yaml")


def _keys(model: str, prefix: str, kind: str) -> Iterator[Entry]:
    hints = get_type_hints(keys.MODELS[model], include_extras=True)
    fields = keys.MODELS[model].model_fields
    for (name, field), row in zip(fields.items(), keys.rows(model), strict=True):
        _, value, default, meaning = row
        path = f"{prefix}{field.alias or name}"
        inner = [] if path in ("expert", "variations") else list(_models(hints[name]))
        lines = [line for part in inner for line in keys.rows(part)]
        yield Entry(path, kind, _told(value, default, meaning), lines)
        below = f"{path}.NAME." if "→" in value else f"{path}."
        for part in inner:
            yield from _keys(part, below, kind)


def _models(hint: Any) -> Iterator[str]:
    """The models that values of an annotation are, or hold."""
    if isinstance(hint, type) and issubclass(hint, BaseModel):
        if hint.__name__ in keys.MODELS:
            yield hint.__name__
        return
    for inner in get_args(hint):
        yield from _models(inner)


def _told(value: str, default: str, meaning: str) -> str:
    given = {"": "", "required": "; required", "none": "", "see meaning": ""}.get(
        default, f"; by default {default}"
    )
    return f"{meaning}\n\nValue: {_without_links(value)}{given}."


def _without_links(text: str) -> str:
    return re.sub(r"\[([^]]*)\]\(#[^)]*\)", r"\1", text)


def as_data(entry: Entry) -> Mapping[str, Any]:
    """An entry as plain data."""
    lines = [dict(zip(keys.HEAD, map(_without_links, line), strict=True)) for line in entry.keys]
    return {"name": entry.name, "kind": entry.kind, "text": entry.text, "keys": lines}
