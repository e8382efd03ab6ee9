"""What setup.cfg cannot say: where the library goes in a wheel, and what package indexes show.

In a checkout the tasks, robots and objects are folders beside the package. Were they mapped there
by ``package_dir``, an editable install would find the package through an import hook, which type
checkers do not follow. Without a mapping it is one line in a .pth file, which they do.

Package indexes show the README. They have no pictures and no files of this repository, so pictures
become their own words, and links to files become plain text.

The archive of sources is the same bytes each time, and a hundredth smaller than that of setuptools:
its files are sorted by their endings, and have neither owners nor times.
"""

import gzip
import io
import re
import tarfile
from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py
from setuptools.command.sdist import sdist

LIBRARY = (
    "tasks/*.py",
    "tasks/*.yaml",
    "tasks/index.json",
    "tasks/proofs.json",
    "tasks/versions.json",
    "tasks/objects/*.urdf",
    "tasks/objects/*.obj",
    "robots/*/robot.yaml",
    "robots/*/*.urdf",
    "robots/*/meshes/*.obj",
    "robots/*/LICENSE",
    "objects/*/object.yaml",
    "objects/*/*.urdf",
    "objects/*/*.obj",
    "objects/*/*.mtl",
    "objects/*/*.png",
)


class BuildWithLibrary(build_py):
    """Copies the library's files into the package that a wheel is made of."""

    def run(self) -> None:
        """Build as always; then, for a wheel, add the library."""
        super().run()
        if not self.editable_mode:
            for source, target in self._library():
                self.mkpath(str(Path(target).parent))
                self.copy_file(source, target)

    def get_source_files(self) -> list[str]:
        """What an sdist must have, the library included."""
        return [*super().get_source_files(), *(source for source, _ in self._library())]

    def get_outputs(self, include_bytecode: bool = True) -> list[str]:
        """What is built, the library included."""
        built: list[str] = super().get_outputs(include_bytecode)
        return built if self.editable_mode else [*built, *(to for _, to in self._library())]

    def _library(self) -> list[tuple[str, str]]:
        """Every file of the library, and where it goes."""
        files = sorted(file for pattern in LIBRARY for file in Path().glob(pattern))
        return [(str(file), str(Path(self.build_lib, "taskbuilder", file))) for file in files]


class PlainArchive(sdist):
    """Packs the sources without what differs between machines and moments."""

    def run(self) -> None:
        """Pack as always; then pack again."""
        super().run()
        for archive in map(Path, self.get_archive_files()):
            if archive.name.endswith(".tar.gz"):
                _repack(archive)


def _repack(archive: Path) -> None:
    with tarfile.open(archive) as packed:
        files = [(file, packed.extractfile(file)) for file in packed if file.isfile()]
        packing = io.BytesIO()
        with (
            gzip.GzipFile("", "wb", 9, packing, mtime=0) as raw,
            tarfile.open(fileobj=raw, mode="w", format=tarfile.GNU_FORMAT) as again,
        ):
            for file, content in sorted(files, key=lambda each: _by_ending(each[0].name)):
                file.uid = file.gid = file.mtime = 0
                file.uname = file.gname = ""
                again.addfile(file, content)
    archive.write_bytes(packing.getvalue())


def _by_ending(name: str) -> tuple[str, str]:
    return Path(name).suffix, name


_PICTURE = re.compile(r"!\[([^\]]*)\]\((?!\w+:)[^)]*\)")
_LINK = re.compile(r"\[([^\]]*)\]\((?!\w+:|#)[^)]*\)")


def long_description() -> str:
    """The README without what leads into the repository."""
    text = Path(__file__).with_name("README.md").read_text(encoding="utf-8")
    return _LINK.sub(
        r"\1", _PICTURE.sub(r"*(In the repository there is a picture here: \1.)*", text)
    )


if __name__ == "__main__":
    setup(
        cmdclass={"build_py": BuildWithLibrary, "sdist": PlainArchive},
        long_description=long_description(),
        long_description_content_type="text/markdown",
    )
