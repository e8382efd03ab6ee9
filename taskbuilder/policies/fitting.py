"""The environment that a policy was trained in, and whether it fits the one that it is to play."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from gymnasium import spaces

from taskbuilder.env.options import from_json, option_infos, options_about
from taskbuilder.env.parallel import TaskEnv
from taskbuilder.env.spaces import VECTOR
from taskbuilder.errors import UsageError
from taskbuilder.policies.trained import TrainedPolicy
from taskbuilder.schema.catalogue import looks_like_path
from taskbuilder.schema.grasping import rules_of
from taskbuilder.schema.other_robots import other_robots

OPTIONS = tuple(name for name, info in option_infos().items() if info.decides_policy)
"""Options of environments that a policy records, because it depends on them."""


def options_of(policy: TrainedPolicy) -> dict[str, Any]:
    """The options of the environment that a policy was trained in, without its start states.

    Raises:
        UsageError: The policy does not record them.
    """
    options = policy.about.get("env")
    if not isinstance(options, Mapping):
        raise UsageError("the policy does not say what its environment was; train it anew")
    return env_options(options)


def env_options(options: Mapping[str, Any]) -> dict[str, Any]:
    """The options of an environment that a policy depends on, from a file's JSON."""
    return {name: value for name, value in from_json(options).items() if name in OPTIONS}


def check_options(trained: Mapping[str, Any], asked: Mapping[str, Any], name: str) -> None:
    """Check that a policy can play with the options that are asked for.

    Args:
        trained: The options of the environment that it was trained in.
        asked: Options that are asked for.
        name: Name of the policy, for messages.

    Raises:
        UsageError: With one of them, the policy would observe or act otherwise than in training.
    """
    for robot, model in () if "robots" in asked else other_robots(trained.get("robots", ())):
        if looks_like_path(model):  # of the machine that reads it, and a policy may be anybody's
            raise UsageError(
                f"{name} was trained with a robot of a file; name the file: --robot {robot}=FILE"
            )
    for option in options_about("observed"):
        free = option_infos()[option].disturbs or option not in trained
        if not free and asked.get(option, trained[option]) != trained[option]:
            raise UsageError(
                f"{name} was trained with {option} {trained[option]}, and plays with no other; "
                f"it is asked for {option} {asked[option]}"
            )


def check_fits(
    policy: TrainedPolicy, env: TaskEnv, name: str = "the policy", *, any_grasp: bool = False
) -> None:
    """Check that a policy fits an environment.

    Args:
        policy: The policy.
        env: The environment, with the policy's options.
        name: Name of the policy, for messages.
        any_grasp: Whether grippers may hold objects by another rule than in training.

    Raises:
        UsageError: It was trained on another task, for other agents, with spaces of other sizes, or
            with another rule of grasping.
    """
    task, trained = env.task.name, policy.about.get("task")
    if trained != task:
        raise UsageError(f"{name} was trained on {trained}, not on {task}")
    if set(policy.networks) != set(env.possible_agents):
        theirs, ours = ", ".join(policy.networks), ", ".join(env.possible_agents)
        raise UsageError(f"{name} plays {theirs}, and {task} as it is now has {ours}; train anew")
    if not any_grasp:
        _check_grasp(policy, env, name)
    policy.check_env(env, name)
    for agent in policy.networks:
        had, has = _sizes(policy, agent, name), _numbers(env, agent)
        for does, size, needed in zip(("sees", "acts by"), had, has, strict=True):
            if size != needed:
                now = f"in {task} as it is now {needed}"
                raise UsageError(f"{name}: {agent} {does} {size} numbers, {now}; train it anew")


def _check_grasp(policy: TrainedPolicy, env: TaskEnv, name: str) -> None:
    """Check that grippers hold objects by the rules of training; early policies state none."""
    world = env.episode.world
    now = rules_of(world.scene, world.task.robots)
    trained = policy.about.get("grasp_rules", {})
    for agent, rule in now.items():
        if (was := trained.get(agent, "friction")) != rule:
            raise UsageError(
                f"{name} was trained with grasp {was}, and {agent} holds objects by {rule} here; "
                f"to play it all the same, ask for it: --grasp {rule}, or grasp={rule!r}"
            )


def _sizes(policy: TrainedPolicy, agent: str, name: str) -> tuple[int, int]:
    """How many numbers a policy takes for an agent, and how many it gives."""
    try:
        return policy.sizes(agent)
    except (ValueError, TypeError, IndexError):
        raise UsageError(f"{name} is damaged: its layers do not fit each other") from None


def _numbers(env: TaskEnv, agent: str) -> tuple[int, int]:
    """The sizes of an agent's observation and action."""
    observed = env.observation_space(agent)
    if isinstance(observed, spaces.Dict) and VECTOR in observed.spaces:
        observed = observed[VECTOR]
    shapes = observed.shape, env.action_space(agent).shape
    observations, actions = (shape[0] if shape else 0 for shape in shapes)
    return observations, actions
