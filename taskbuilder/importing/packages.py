"""Where the files are that a robot description names, and how far an import may look for them."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from urllib.parse import unquote

from taskbuilder.assets import codes
from taskbuilder.assets.paths import AssetError, require_readable
from taskbuilder.errors import display_path
from taskbuilder.wording import quoted, suggestion

MAX_BYTES = 256 * 2**20
"""Of a mesh before it is decimated; what is written has at most `taskbuilder.assets` allows."""

_MANIFEST = "package.xml"
_MODEL = "model.config"
_NAME = re.compile(r"<name>\s*([\w.+-]+)\s*</name>")
_SCHEMES = ("package://", "model://")
_SHALLOWEST = 2  # parts of a path that are too general to be a package: /, /home, /tmp
_LEVELS = 3  # folders above a package that may be its workspace
_DEPTH = 3  # folders below a workspace in which packages are looked for
_SKIPPED = frozenset({"node_modules", "build", "install", "log", "meshes", "site-packages"})


@dataclass
class Packages:
    """Finds packages and files, and refuses those that lie outside.

    Attributes:
        file: The file that is imported.
        root: The folder inside which relative paths may lead; by default the ROS package of the
            file or, without one, the folder above the folder of the file.
        given: Package name -> folder, as the user gives them.
    """

    file: Path
    root: Path
    given: Mapping[str, Path] = field(default_factory=dict)
    _found: dict[str, Path] = field(default_factory=dict, repr=False)
    _admitted: tuple[Path, ...] = ()

    @classmethod
    def around(
        cls, file: Path, given: Mapping[str, Path] | None = None, root: Path | None = None
    ) -> Packages:
        """The packages around a file.

        Args:
            file: The file that is imported.
            given: Package name -> folder.
            root: The import root, if it is not to be found.
        """
        file = file.resolve()
        folders = {name: folder.resolve() for name, folder in (given or {}).items()}
        return cls(file, (root or _default_root(file)).resolve(), folders)

    @property
    def roots(self) -> tuple[Path, ...]:
        """The folders inside which files may lie: the root, and the packages found so far."""
        return (self.root, *self.given.values(), *self._found.values(), *self._admitted)

    def admit(self, folders: tuple[Path, ...]) -> None:
        """Allow files of further folders, such as those of a gripper that is mounted."""
        self._admitted += folders

    def locate(self, reference: str, folder: Path) -> Path:
        """The existing file that a reference means.

        Args:
            reference: ``package://NAME/…``, ``model://NAME/…``, ``file://…`` or a path.
            folder: Folder of the file that holds the reference.

        Raises:
            AssetError: There is none, it lies outside the import root, or it cannot be read.
        """
        path = self._spelled(reference.strip(), folder)
        actual = path.resolve()
        if not any(actual.is_relative_to(root) for root in self.roots):
            raise AssetError(
                codes.OUTSIDE,
                f"{quoted(reference)} lies outside the import root {display_path(self.roots[0])}; "
                "widen it with --root, or name its package with --package NAME=DIR",
            )
        require_readable(actual, reference, MAX_BYTES)
        return actual

    def find(self, name: str) -> Path:
        """The folder of a package.

        Raises:
            AssetError: There is none, or there are several.
        """
        if name in self.given:
            return self.given[name]
        if name not in self._found:
            self._found[name] = self._search(name)
        return self._found[name]

    def _spelled(self, reference: str, folder: Path) -> Path:
        if not reference:
            raise AssetError(codes.MISSING, "the file name is empty; name a file")
        if "\\" in reference or not reference.isprintable():
            raise AssetError(
                codes.OUTSIDE, f'{quoted(reference)} is no portable path; separate with "/"'
            )
        for scheme in _SCHEMES:
            if reference.startswith(scheme):
                name, _, rest = reference.removeprefix(scheme).partition("/")
                return self.find(name) / rest.lstrip("/")
        if reference.startswith("file://"):
            return Path(unquote(reference.removeprefix("file://")))
        if re.match(r"[A-Za-z][A-Za-z0-9+.-]+:", reference):
            raise AssetError(
                codes.OUTSIDE, f"{quoted(reference)} is no file here; nothing is downloaded"
            )
        if reference.startswith("~"):
            raise AssetError(codes.OUTSIDE, f"{quoted(reference)} works on one machine only")
        return folder / reference

    def _search(self, name: str) -> Path:
        """Look for a package from the file upwards; the nearest level that has one counts."""
        if name in ("", ".", "..") or "/" in name:
            raise AssetError(codes.MISSING, f"{quoted(name)} is no name of a package")
        package = _package_of(self.file)
        above = [package, *package.parents][: _LEVELS + 1]
        for base in self.file.parents:
            if len(base.parts) <= _SHALLOWEST:
                break
            candidates = dict.fromkeys(_at_level(base, name, deep=base in above))
            if len(candidates) > 1:
                listed = ", ".join(display_path(one) for one in candidates)
                raise AssetError(
                    codes.AMBIGUOUS,
                    f"the package {quoted(name)} is there {len(candidates)} times ({listed}); "
                    f"say which with --package {name}=DIR",
                )
            if candidates:
                return next(iter(candidates))
        near = suggestion(name, list(_names_nearby(self.file)), otherwise="")
        hint = f" ({near})" if near else ""
        raise AssetError(
            codes.MISSING,
            f"no package {quoted(name)} was found from {self.file.name} upwards{hint}; "
            f"say where it is with --package {name}=DIR",
        )


def _default_root(file: Path) -> Path:
    """The package or repository of a file or, without one, the folder above its folder."""
    for folder in file.parents:
        if len(folder.parts) <= _SHALLOWEST:
            break
        if (folder / _MANIFEST).is_file() or (folder / ".git").exists():
            return folder
    above = file.parent.parent
    return above if len(above.parts) > _SHALLOWEST else file.parent


def _package_of(file: Path) -> Path:
    """The nearest folder with a manifest, or the folder of the file."""
    return next((one for one in file.parents if package_name(one)), file.parent)


def _at_level(base: Path, name: str, *, deep: bool) -> Iterator[Path]:
    """Packages of a name: a folder itself, one in it, or one further below with a manifest."""
    if base.name == name or package_name(base) == name:
        yield base
        return
    if (base / name).is_dir():
        yield base / name
        return
    if not deep or len(base.parts) <= _SHALLOWEST + 1:  # a home holds more than a workspace
        return
    for folder in _manifests(base, _DEPTH):
        if package_name(folder) == name or folder.name == name:
            yield folder


def _manifests(folder: Path, depth: int) -> Iterator[Path]:
    """The packages below a folder, which do not nest."""
    try:
        below = sorted(one for one in folder.iterdir() if one.is_dir() and not one.is_symlink())
    except OSError:
        return
    for one in below:
        if one.name.startswith(".") or one.name in _SKIPPED:
            continue
        if package_name(one):
            yield one
        elif depth > 1:
            yield from _manifests(one, depth - 1)


def _names_nearby(file: Path) -> Iterator[str]:
    for base in list(file.parents)[:3]:
        if len(base.parts) > _SHALLOWEST:
            yield from (package_name(one) for one in _manifests(base, 1))


def package_name(folder: Path) -> str:
    """The name in the manifest of a folder, or "" if it is no package."""
    for manifest in (_MANIFEST, _MODEL):
        file = folder / manifest
        if file.is_file():
            try:
                text = file.read_text(encoding="utf-8", errors="replace")[:20_000]
            except OSError:
                return folder.name
            named = _NAME.search(text)
            return named[1] if named else folder.name
    return ""
