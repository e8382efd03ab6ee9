"""TorchRL: the handover as a multi-agent environment of tensors, with the critic's state."""

from tensordict import TensorDictBase
from torchrl.envs import MarlGroupMapType, PettingZooWrapper

import taskbuilder


def make() -> PettingZooWrapper:
    """An environment with a group for each arm: what they see may differ in size."""
    env = taskbuilder.NumericInfos(taskbuilder.parallel_env("handover"))
    groups = MarlGroupMapType.ONE_GROUP_PER_AGENT
    return PettingZooWrapper(env, group_map=groups, return_state=True)


def main(steps: int = 50) -> TensorDictBase:
    """Act at random for some control steps."""
    env = make()
    rollout = env.rollout(steps)
    env.close()
    return rollout


if __name__ == "__main__":
    main()
