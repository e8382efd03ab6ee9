"""BenchMARL's algorithms on a task: MADDPG or MAPPO, for a few iterations.

    python examples/benchmarl_task.py [TASK] [maddpg|mappo]

BenchMARL 1.5 needs TorchRL 0.10 or 0.11: pip install benchmarl "torchrl<0.12"
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Callable
from typing import Any

from benchmarl.algorithms import MaddpgConfig, MappoConfig
from benchmarl.environments.common import TaskClass
from benchmarl.experiment import Experiment, ExperimentConfig
from benchmarl.models.mlp import MlpConfig
from torchrl.data import Composite
from torchrl.envs import EnvBase, MarlGroupMapType, PettingZooWrapper

import taskbuilder

ALGORITHMS = {"maddpg": MaddpgConfig, "mappo": MappoConfig}


class TaskbuilderTask(TaskClass):
    """A task of taskbuilder; ``config`` has the options of its environment."""

    def __init__(self, name: str, config: dict[str, Any] | None = None) -> None:
        super().__init__(name, config or {})

    def get_env_fun(
        self, num_envs: int, continuous_actions: bool, seed: int | None, device: Any
    ) -> Callable[[], EnvBase]:
        """How an environment is made; robots differ, so that each is a group of its own."""

        def make() -> EnvBase:
            env = taskbuilder.NumericInfos(taskbuilder.parallel_env(self.name, **self.config))
            groups = MarlGroupMapType.ONE_GROUP_PER_AGENT
            return PettingZooWrapper(
                env, group_map=groups, return_state=True, seed=seed, device=device
            )

        return make

    def supports_continuous_actions(self) -> bool:
        return True

    def supports_discrete_actions(self) -> bool:
        return False

    def has_render(self, env: EnvBase) -> bool:
        return False

    def max_steps(self, env: EnvBase) -> int:
        return int(taskbuilder.load_task(self.name).file.spec.timing.episode_steps)

    def group_map(self, env: EnvBase) -> dict[str, list[str]]:
        return dict(env.group_map)

    def observation_spec(self, env: EnvBase) -> Composite:
        return self._kept(env, "observation")

    def info_spec(self, env: EnvBase) -> Composite | None:
        return self._kept(env, "info")

    def action_spec(self, env: EnvBase) -> Composite:
        return env.full_action_spec

    def state_spec(self, env: EnvBase) -> Composite | None:
        return Composite({"state": env.observation_spec["state"].clone()})

    def action_mask_spec(self, env: EnvBase) -> Composite | None:
        return None

    @staticmethod
    def env_name() -> str:
        return "taskbuilder"

    def _kept(self, env: EnvBase, wanted: str) -> Composite:
        """Of what each robot is told, one part."""
        spec = env.observation_spec.clone()
        del spec["state"]
        for group in env.group_map:
            for key in set(spec[group].keys()) - {wanted}:
                del spec[group][key]
        return spec


def main(task: str = "handover", algorithm: str = "maddpg", iterations: int = 2) -> Experiment:
    """Train for some iterations of a few episodes."""
    config = ExperimentConfig.get_from_yaml()
    steps = 2 * taskbuilder.load_task(task).file.spec.timing.episode_steps
    config.max_n_frames, config.max_n_iters = None, iterations
    for kind in ("on_policy", "off_policy"):
        setattr(config, f"{kind}_collected_frames_per_batch", steps)
        setattr(config, f"{kind}_n_envs_per_worker", 1)
    config.on_policy_n_minibatch_iters, config.on_policy_minibatch_size = 2, 32
    config.off_policy_n_optimizer_steps, config.off_policy_train_batch_size = 4, 32
    config.off_policy_memory_size = 1000
    config.evaluation, config.loggers, config.create_json = False, [], False
    config.save_folder = tempfile.mkdtemp()
    experiment = Experiment(
        task=TaskbuilderTask(task),
        algorithm_config=ALGORITHMS[algorithm].get_from_yaml(),
        model_config=MlpConfig.get_from_yaml(),
        critic_model_config=MlpConfig.get_from_yaml(),
        seed=0,
        config=config,
    )
    experiment.run()
    return experiment


if __name__ == "__main__":
    main(*sys.argv[1:3])
