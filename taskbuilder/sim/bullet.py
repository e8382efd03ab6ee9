"""The one door to pybullet.

`p` is the module, for its constants. Functions are called through `Calls`, which binds them to a
client and turns pybullet's untyped errors into `SimulationError`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from taskbuilder.errors import SimulationError
from taskbuilder.sim.engine_output import import_pybullet
from taskbuilder.sim.single import Single

__all__ = ["Calls", "p"]

p = import_pybullet()


class Calls(Single):
    """Pybullet's functions, called on one client.

    ``calls.getBodyInfo(3)`` is ``pybullet.getBodyInfo(3, physicsClientId=…)``, and what pybullet
    refuses raises `SimulationError`. Binding costs about 0.1 µs a call.
    """

    def __init__(self, client_id: int) -> None:
        self._client_id: int | None = client_id

    def __getattr__(self, name: str) -> Callable[..., Any]:
        # Reached once a function: the bound one is kept as an attribute of the instance.
        if name.startswith("_"):
            raise AttributeError(name)
        if self._client_id is None:
            raise SimulationError(f"{name} was called on a client that is closed; open a new one")
        bound = _bound(getattr(p, name), self._client_id)
        setattr(self, name, bound)
        return bound

    def retire(self) -> None:
        """Refuse every later call: Bullet gives the ids of closed clients to new ones."""
        vars(self).clear()
        self._client_id = None


def _bound(function: Callable[..., Any], client_id: int) -> Callable[..., Any]:
    def call(*arguments: Any, **options: Any) -> Any:
        try:
            return function(*arguments, physicsClientId=client_id, **options)
        except p.error as refusal:
            raise SimulationError(f"Bullet refused {function.__name__}: {refusal}") from refusal

    return call
