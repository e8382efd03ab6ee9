"""TorchRL: its own MADDPG learns the handover for a while.

Actors that see their own observation, a critic for each arm that sees both arms' observations and
actions, and the team's reward for both (Lowe et al. 2017), out of TorchRL's parts alone.
"""

from dataclasses import dataclass, field

import torch
from tensordict import TensorDictBase
from tensordict.nn import TensorDictModule, TensorDictSequential
from torch import nn
from torchrl.data import LazyTensorStorage, ReplayBuffer
from torchrl.envs import EnvBase, PettingZooWrapper
from torchrl.modules import AdditiveGaussianModule, MultiAgentMLP, ProbabilisticActor, TanhDelta
from torchrl.objectives import DDPGLoss, SoftUpdate, ValueEstimators

import taskbuilder

ARMS = ("arms", "observation"), ("arms", "action"), ("arms", "state_action_value")
SEEN, SAID, VALUE = ARMS
BATCH, LR, DISCOUNT, TAU, NOISE = 128, 1e-3, 0.95, 0.01, 0.3


@dataclass
class Course:
    """How a training went: the return of every episode, and the losses of every update."""

    returns: list[float] = field(default_factory=list)
    losses: list[float] = field(default_factory=list)


def make() -> EnvBase:
    """An environment whose arms are one group: they see and say equally many numbers."""
    env = taskbuilder.NumericInfos(taskbuilder.parallel_env("handover", frame="base"))
    return PettingZooWrapper(env, group_map={"arms": list(env.possible_agents)})


def actors(env: EnvBase) -> ProbabilisticActor:
    """A network for each arm, which sees what that arm sees; ends in a tanh."""
    network = _network(
        env, env.observation_spec[SEEN].shape[-1], env.full_action_spec[SAID].shape[-1]
    )
    return ProbabilisticActor(
        TensorDictModule(network, [SEEN], [("arms", "param")]),
        spec=env.full_action_spec[SAID],
        in_keys=[("arms", "param")],
        out_keys=[SAID],
        distribution_class=TanhDelta,
        distribution_kwargs={
            "low": env.full_action_spec[SAID].space.low,
            "high": env.full_action_spec[SAID].space.high,
        },
    )


def critics(env: EnvBase) -> TensorDictSequential:
    """A network for each arm, which sees what all see and do."""
    size = env.observation_spec[SEEN].shape[-1] + env.full_action_spec[SAID].shape[-1]
    joined, both = ("arms", "seen_and_said"), [SEEN, SAID]
    return TensorDictSequential(
        TensorDictModule(lambda seen, said: torch.cat([seen, said], -1), both, [joined]),
        TensorDictModule(_network(env, size, 1, centralized=True), [joined], [VALUE]),
    )


def _network(env: EnvBase, ins: int, outs: int, *, centralized: bool = False) -> MultiAgentMLP:
    return MultiAgentMLP(
        ins,
        outs,
        n_agents=env.observation_spec[SEEN].shape[0],
        centralized=centralized,
        share_params=False,
        depth=2,
        num_cells=64,
        activation_class=nn.ReLU,
    )


def main(episodes: int = 200, updates: int = 50, seed: int = 0) -> Course:
    """Train; tell how it went.

    Args:
        episodes: How many, of 50 control steps each.
        updates: After every episode.
        seed: Of the environment, the networks and the noise.
    """
    torch.manual_seed(seed)
    env = make()
    env.set_seed(seed)
    actor, critic, course = actors(env), critics(env), Course()
    noise = AdditiveGaussianModule(
        env.full_action_spec[SAID],
        annealing_num_steps=episodes * 50,
        sigma_init=NOISE,
        sigma_end=0.1,
        action_key=SAID,
    )
    loss = DDPGLoss(actor, critic, delay_actor=True, delay_value=True)
    loss.set_keys(
        state_action_value=VALUE,
        reward=("arms", "reward"),
        done=("arms", "done"),
        terminated=("arms", "terminated"),
    )
    loss.make_value_estimator(ValueEstimators.TD0, gamma=DISCOUNT)
    targets = SoftUpdate(loss, tau=TAU)
    adams = [
        torch.optim.Adam(loss.actor_network_params.flatten_keys().values(), LR),
        torch.optim.Adam(loss.value_network_params.flatten_keys().values(), LR),
    ]
    memory = ReplayBuffer(storage=LazyTensorStorage(episodes * 50), batch_size=BATCH)
    for _ in range(episodes):
        with torch.no_grad():
            rollout = env.rollout(50, TensorDictSequential(actor, noise))
        noise.step(len(rollout))
        course.returns.append(float(rollout["next", "arms", "reward"].sum(0).mean()))
        memory.extend(rollout)
        for _ in range(updates):
            course.losses.append(_learn(memory.sample(), loss, adams))
            targets.step()
    env.close()
    return course


def _learn(batch: TensorDictBase, loss: DDPGLoss, adams: list[torch.optim.Adam]) -> float:
    """One update of actors and critics; gives the critics' loss."""
    found = loss(batch)
    for adam, part in zip(adams, ("loss_actor", "loss_value"), strict=True):
        adam.zero_grad()
        found[part].backward()
        adam.step()
    return float(found["loss_value"].detach())


if __name__ == "__main__":
    main()
