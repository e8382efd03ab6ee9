"""Golden cases: a text file that holds a command, the files it works on, and what it prints.

::

    One sentence that says what is wrong.
    $ taskbuilder validate broken.yaml
    -- broken.yaml --
    task: broken
    -- expected (exit 1) --
    broken.yaml:1:1: error[TB101] …

In front of the command stand environment variables, if any: ``$ A=b taskbuilder …``. A file whose
content a text file cannot show well says in brackets how it is made:

- ``(copy of good.py)``: from the folder ``shared``
- ``(escaped)``: with backslash escapes, such as ``\\xff``, each for one byte
- ``(python)``: the text or bytes that an expression gives
- ``(folder)``, ``(link to TARGET)``
"""

from __future__ import annotations

import re
import shlex
import shutil
from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).parent

_SECTION = re.compile(r"-- (?P<name>[^(]+?)(?: \((?P<how>.*)\))? --")


@dataclass(frozen=True)
class Part:
    """A file of a case: its path, how it is made, and the text below its heading."""

    name: str
    how: str
    text: str


@dataclass(frozen=True)
class Case:
    """A golden file, taken apart."""

    file: Path
    sentence: str
    environment: dict[str, str]
    words: list[str]
    parts: tuple[Part, ...]
    exit: int
    expected: str

    def write(self, folder: Path) -> None:
        """Make the case's files."""
        for part in self.parts:
            path = folder / part.name
            path.parent.mkdir(parents=True, exist_ok=True)
            _make(path, part)

    def update(self, status: int, printed: str) -> None:
        """Put what was printed in place of what was expected."""
        before = self.file.read_text(encoding="utf-8").split("\n-- expected ", 1)[0]
        text = f"{before}\n-- expected (exit {status}) --\n{printed}"
        self.file.write_text(text, encoding="utf-8")


def read_case(file: Path) -> Case:
    """Take a golden file apart."""
    sentence, command, *lines = file.read_text(encoding="utf-8").splitlines(keepends=True)
    parts: list[Part] = []
    for line in lines:
        if heading := _SECTION.fullmatch(line.strip()):
            parts.append(Part(heading["name"], heading["how"] or "", ""))
        else:
            parts[-1] = Part(parts[-1].name, parts[-1].how, parts[-1].text + line)
    *files, expected = parts
    prompt, *words = shlex.split(command)
    if (prompt, expected.name) != ("$", "expected"):
        raise ValueError(f"{file} begins with no sentence and command, or expects nothing")
    start = words.index("taskbuilder")
    environment = dict(word.split("=", 1) for word in words[:start])
    status = int(expected.how.removeprefix("exit "))
    return Case(
        file,
        sentence.strip(),
        environment,
        words[start + 1 :],
        tuple(files),
        status,
        expected.text,
    )


def _make(path: Path, part: Part) -> None:
    kind, _, target = part.how.rpartition(" ")
    if part.how == "folder":
        path.mkdir()
    elif kind == "link to":
        path.symlink_to(target)
    elif kind == "copy of":
        shutil.copy(HERE / "shared" / target, path)
    elif part.how == "escaped":
        path.write_bytes(part.text.rstrip("\n").encode().decode("unicode_escape").encode("latin-1"))
    elif part.how == "python":
        made = eval(part.text)  # of this folder's files only
        path.write_bytes(made if isinstance(made, bytes) else made.encode())
    elif not part.how:
        path.write_text(part.text, encoding="utf-8")
    else:
        raise ValueError(f"{part.name}: nothing is made by ({part.how})")
