"""Policies: who plays, in one grammar, and trained policies and policy servers.

    from taskbuilder.policies import parse_policy

    player = parse_policy("zoo:handover/demos")

Names are imported on first use; nothing here needs PyTorch.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from taskbuilder._lazy import exported

if TYPE_CHECKING:
    from taskbuilder.policies.grammar import Player, PolicyLike, parse_policy
    from taskbuilder.policies.served import PolicyServer
    from taskbuilder.policies.trained import TrainedPolicy
    from taskbuilder.policies.zoo import load_policy, save_policy

__all__ = [
    "Player",
    "PolicyLike",
    "PolicyServer",
    "TrainedPolicy",
    "load_policy",
    "parse_policy",
    "save_policy",
]

_HOMES = {
    "Player": "taskbuilder.policies.grammar",
    "PolicyLike": "taskbuilder.policies.grammar",
    "PolicyServer": "taskbuilder.policies.served",
    "TrainedPolicy": "taskbuilder.policies.trained",
    "load_policy": "taskbuilder.policies.zoo",
    "parse_policy": "taskbuilder.policies.grammar",
    "save_policy": "taskbuilder.policies.zoo",
}

if not TYPE_CHECKING:
    __getattr__, __dir__ = exported(__name__, _HOMES)
