"""Sharing tasks, data sets, policies and certificates, as plain folders."""

from __future__ import annotations

from typing import TYPE_CHECKING

from taskbuilder._lazy import exported

if TYPE_CHECKING:
    from taskbuilder.sharing.pulling import Pulled, pull
    from taskbuilder.sharing.pushing import Pushed, push

__all__ = ["Pulled", "Pushed", "pull", "push"]

_HOMES = {
    "Pulled": "taskbuilder.sharing.pulling",
    "Pushed": "taskbuilder.sharing.pushing",
    "pull": "taskbuilder.sharing.pulling",
    "push": "taskbuilder.sharing.pushing",
}

__getattr__, __dir__ = exported(__name__, _HOMES)
