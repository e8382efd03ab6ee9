"""The views of a task's environment, compared with its scene.

They are the multi-agent, joint, turn-based (AEC) and vector environment. The multi-agent one is
compared where the contract family plays it anyway; the others play a few steps here.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import closing
from itertools import islice

from pettingzoo.utils.conversions import parallel_to_aec

from taskbuilder.env.joint import JointEnv
from taskbuilder.env.options import EnvOptions, Options
from taskbuilder.env.vector import make_vec
from taskbuilder.task import Task
from taskbuilder.validate.comparing import Compared, play_ends
from taskbuilder.validate.env_cache import SMALL, EnvCache
from taskbuilder.validate.observing import Find
from taskbuilder.validate.playing import random_actions
from taskbuilder.validate.report import Result
from taskbuilder.validate.stages import SingleAgent, TurnBased
from taskbuilder.validate.vectors import check_vector

STEPS = 2
"""Control steps that the turn-based environment plays before it is made to end."""

HORIZON = 3
"""Length of the episodes of the joint and the vector environment, so that some end."""

Differences = Mapping[str, Mapping[str, str]]
"""Messages by code and by what they are about."""


def compare_turns(cache: EnvCache, seed: int) -> Differences:
    """Compare the turn-based (AEC) environment of a task with its scene.

    Args:
        cache: The environments of the process.
        seed: Seed of the episodes.
    """
    env = cache.env(0)
    turns = TurnBased(parallel_to_aec(env))
    compared = Compared(turns, env, view="the turn-based environment")
    play_ends(compared, seed, list(islice(random_actions(env, seed), STEPS)))
    return compared.wrong


def check_views(task: Task, find: Find, options: Options) -> tuple[Differences, Result]:
    """Compare the joint and the vector environment of a task, with pictures of all its cameras.

    The joint environment is compared with its scene. The multi-agent environment in it plays what
    the rows of the vector environment should.

    Args:
        task: The task.
        find: Makes findings.
        options: Options of both, besides their length and pictures.
    """
    kept: EnvOptions = {
        **options.chosen,
        "horizon": HORIZON,
        "camera_size": SMALL,
        "cameras": tuple(task.file.spec.scene.cameras),
    }
    with closing(JointEnv(task, **kept)) as env, closing(make_vec(task, 2, **kept)) as vec:
        env.action_space.seed(0)
        compared = Compared(SingleAgent(env), env.parallel, view="JointEnv")
        # The same action again, so that arms move away from where they stand.
        play_ends(compared, 0, [{"agent": env.action_space.sample()}] * (HORIZON - 1))
        return compared.wrong, check_vector(find, vec, env.parallel, 0, HORIZON + 1)
