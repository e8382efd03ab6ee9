"""Playing, resuming and replaying episodes, and the record of an episode.

env = taskbuilder.parallel_env("handover")
rollout = play(env, RandomActions(), seed=0)
rollout.success, rollout.team_return, rollout.actions["left"].shape
"""

from taskbuilder.env.action_encoder import Actions
from taskbuilder.rollout.files import load_rollouts, save_rollouts
from taskbuilder.rollout.play import Act, Policy, play, replay, replaying, resume
from taskbuilder.rollout.players import Function, HoldStill, RandomActions, RecordedActions
from taskbuilder.rollout.record import Rollout, ScriptLog, Trouble

__all__ = [
    "Act",
    "Actions",
    "Function",
    "HoldStill",
    "Policy",
    "RandomActions",
    "RecordedActions",
    "Rollout",
    "ScriptLog",
    "Trouble",
    "load_rollouts",
    "play",
    "replay",
    "replaying",
    "resume",
    "save_rollouts",
]
