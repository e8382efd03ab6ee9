"""Choose the tests that only `--runslow` runs, from how long all of them took.

    pytest -n 3 --dist worksteal --durations=0 --durations-min=0.02 > durations.txt
    python tests/slowest.py durations.txt

Writes tests/slow.txt: tests that took longer than `LONGEST_S`, without what they set up, which
others need as well. Some stay, because they are to be tried at every change: every task of the
library, and what strangers see first. `make slow` runs the others.
"""

from __future__ import annotations

import re
import sys
from collections import Counter
from collections.abc import Iterable
from pathlib import Path

LONGEST_S = 4.0
STAY = (
    "tests/library/",
    "tests/docs/test_readme.py",
    "tests/docs/test_generated.py",
    "tests/schema/test_without_engine.py",
    "tests/test_architecture.py",
    "tests/test_engine.py",
    "tests/test_packaging.py",
    "tests/test_public_face.py",
)
SLOW = Path(__file__).with_name("slow.txt")
_LINE = re.compile(r"\s*([\d.]+)s call\s+(tests/.*\S)")


def slowest(lines: Iterable[str]) -> list[str]:
    """The names of the tests that took too long."""
    took: Counter[str] = Counter()
    for line in lines:
        if match := _LINE.match(line):
            took[match[2]] += float(match[1])
    return sorted(
        name for name, seconds in took.items() if seconds > LONGEST_S and not name.startswith(STAY)
    )


def main() -> None:
    """Write the list."""
    text = Path(sys.argv[1]).read_text(encoding="utf-8")
    before = SLOW.read_text(encoding="utf-8").splitlines() if SLOW.exists() else []
    there = set(before) | set(slowest(text.splitlines()))
    SLOW.write_text("\n".join(sorted(there)) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
