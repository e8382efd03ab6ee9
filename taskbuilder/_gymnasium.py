"""Names for `gymnasium.make`: ``taskbuilder/Handover-v0`` and its like.

Gymnasium finds environments only once somebody has registered them, and importing it takes longer
than all of `taskbuilder --help`. So ``import taskbuilder`` registers them at once where Gymnasium
is already there, and otherwise as soon as it is imported.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType

_ENTRY = "taskbuilder.env.joint:JointEnv"


def register_envs() -> None:
    """Register every task of the library, and ``Task-v0`` for any task by name or path."""
    import gymnasium

    gymnasium.register("taskbuilder/Task-v0", entry_point=_ENTRY)
    for file in _library():
        name = "".join(part.capitalize() for part in file.stem.split("_"))
        gymnasium.register(f"taskbuilder/{name}-v0", entry_point=_ENTRY, kwargs={"task": file.stem})


def register_when_imported() -> None:
    """Register now if Gymnasium is imported, else right after it will be."""
    if "gymnasium" in sys.modules:
        register_envs()
    else:
        sys.meta_path.insert(0, _Waiting())


def _library() -> list[Path]:
    spec = find_spec("taskbuilder.tasks")
    folders = (spec.submodule_search_locations or ()) if spec else ()
    return sorted(file for folder in folders for file in Path(folder).glob("[a-z]*.yaml"))


class _Waiting(MetaPathFinder):
    """Stands first among the finders until Gymnasium is imported, then steps aside."""

    def find_spec(
        self,
        fullname: str,
        path: Sequence[str] | None,  # noqa: ARG002  # the finders' protocol
        target: ModuleType | None = None,  # noqa: ARG002  # likewise
    ) -> ModuleSpec | None:
        """Find Gymnasium as everybody else would, and register once it has been run."""
        if fullname != "gymnasium":
            return None
        sys.meta_path.remove(self)
        spec = find_spec(fullname)
        if spec is None or spec.loader is None:
            return spec
        run = spec.loader.exec_module

        def run_and_register(module: ModuleType) -> None:
            run(module)
            register_envs()

        spec.loader.exec_module = run_and_register  # type: ignore[method-assign]  # of this one loader
        return spec
