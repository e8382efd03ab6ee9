"""All is said in setup.cfg but the text that package indexes show, which is the README's.

An index has no pictures and no files of this repository, so pictures become their own words, and
links to files become plain text.
"""

import re
from pathlib import Path

from setuptools import setup

_PICTURE = re.compile(r"!\[([^\]]*)\]\((?!\w+:)[^)]*\)")
_LINK = re.compile(r"\[([^\]]*)\]\((?!\w+:|#)[^)]*\)")


def long_description() -> str:
    """The README without what leads into the repository."""
    text = Path(__file__).with_name("README.md").read_text(encoding="utf-8")
    return _LINK.sub(
        r"\1", _PICTURE.sub(r"*(In the repository there is a picture here: \1.)*", text)
    )


if __name__ == "__main__":
    setup(long_description=long_description(), long_description_content_type="text/markdown")
