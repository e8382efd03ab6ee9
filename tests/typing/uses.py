"""What a type checker says of programs that use taskbuilder: `make types` checks this file.

Each ``type: ignore`` stands on a mistake that has to be found before anything runs; mypy, told to
warn of ignores that nothing needs, finds those that no longer are.
"""

from typing import assert_type

import gymnasium

import taskbuilder
import taskbuilder.gym

gymnasium.register_envs(taskbuilder.gym)

env = taskbuilder.parallel_env("handover", reward="local", horizon=20, variation="random")
assert_type(env, taskbuilder.TaskEnv)
taskbuilder.parallel_env("handover", reward="locl")  # type: ignore[arg-type]
taskbuilder.parallel_env("handover", rewad="local")  # type: ignore[call-arg]
taskbuilder.parallel_env("handover", render_mode="human")  # type: ignore[arg-type]
taskbuilder.paralel_env("handover")  # type: ignore[attr-defined]

vec = taskbuilder.make_vec("handover", 4, workers=2, observe="scene", autoreset="NextStep")
assert_type(vec, taskbuilder.TaskVectorEnv)
taskbuilder.parallel_env("handover", randomize="look")  # type: ignore[arg-type]
taskbuilder.make_vec("handover", 4, observe="scenes")  # type: ignore[arg-type]

joint = taskbuilder.JointEnv("handover", frame="base", camera_size=(64, 48), pixels="nested")
taskbuilder.JointEnv("handover", frame="tool")  # type: ignore[arg-type]
taskbuilder.JointEnv("handover", camera_size=64)  # type: ignore[arg-type]
taskbuilder.JointEnv("handover", pixels="nest")  # type: ignore[arg-type]

assert_type(taskbuilder.load_dataset("data"), taskbuilder.Dataset)
assert_type(taskbuilder.load_dataset("data")[0], taskbuilder.RecordedEpisode)
assert_type(taskbuilder.make_from("data"), taskbuilder.TaskEnv)

assert_type(taskbuilder.catalogue().tasks["handover"].name, str)
assert_type(taskbuilder.load_task("handover").name, str)
