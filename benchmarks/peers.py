"""Public implementations of MADDPG, driven by their own updates; see learners.py.

Each gets what makes it fast and what its authors would set: plain networks of the same sizes,
no gradient clipping, no layer norm, and, where a user chooses the optimiser, the fused one.
"""

from __future__ import annotations

import itertools
import tempfile
import warnings
from argparse import Namespace
from functools import partial
from typing import Any

import numpy as np
import torch
from contest import (
    ACTION,
    AGENTS,
    BATCH,
    DISCOUNT,
    HIDDEN,
    LR,
    OBSERVATION,
    TAU,
    Batch,
    Contestant,
)
from tensordict import TensorDict
from torch import Tensor, nn


def peers(batches: list[Batch]) -> dict[str, Contestant]:
    """All of them."""
    warnings.simplefilter("ignore")  # of what becomes of these libraries' own calls
    return {
        "AgileRL": agilerl(batches),
        "XuanCe": xuance(batches, shared=False),
        "XuanCe, shared": xuance(batches, shared=True),
        "TorchRL": torchrl(batches, shared=False),
        "TorchRL, shared": torchrl(batches, shared=True),
    }


# --- AgileRL


def agilerl(batches: list[Batch]) -> Contestant:
    """`MADDPG.learn`, an actor and a critic an agent.

    Its own actors have three hidden layers at least, so that they are given; its critics take the
    actions in at the second of two layers.
    """
    from agilerl.algorithms import MADDPG
    from agilerl.modules import EvolvableMLP
    from gymnasium.spaces import Box, Dict

    seen = Dict({agent: Box(-10.0, 10.0, (OBSERVATION,)) for agent in AGENTS})
    said = Dict({agent: Box(-1.0, 1.0, (ACTION,)) for agent in AGENTS})
    made = partial(
        MADDPG,
        seen,
        said,
        agent_ids=list(AGENTS),
        batch_size=BATCH,
        lr_actor=LR,
        lr_critic=LR,
        gamma=DISCOUNT,
        tau=TAU,
    )
    plain = {"hidden_size": [HIDDEN[0]], "layer_norm": False}
    networks = {"encoder_config": plain, "latent_dim": HIDDEN[0], "head_config": plain}
    actor = partial(
        EvolvableMLP,
        OBSERVATION,
        ACTION,
        list(HIDDEN),
        layer_norm=False,
        output_vanish=False,
        output_activation="Tanh",
    )
    learner = made(
        actor_networks=[actor() for _ in AGENTS],
        critic_networks=list(made(net_config=networks).critics.values()),
    )
    given = itertools.cycle([_agilerls(batch) for batch in batches])
    return Contestant("agilerl", 2, 2, "", lambda: learner.learn(next(given)))


def _agilerls(batch: Batch) -> TensorDict:
    def column(values: Any) -> Tensor:
        return torch.from_numpy(values).unsqueeze(1)

    parts = {
        "obs": {agent: torch.from_numpy(batch.observations[agent]) for agent in AGENTS},
        "action": {agent: torch.from_numpy(batch.actions[agent]) for agent in AGENTS},
        "reward": {agent: column(batch.rewards[agent]) for agent in AGENTS},
        "next_obs": {agent: torch.from_numpy(batch.next_observations[agent]) for agent in AGENTS},
        "done": {agent: torch.zeros(BATCH, 1) for agent in AGENTS},
    }
    return TensorDict({name: TensorDict(part, (BATCH,)) for name, part in parts.items()}, (BATCH,))


# --- XuanCe


def xuance(batches: list[Batch], *, shared: bool) -> Contestant:
    """`MADDPG_Learner.update`, with networks of each agent's own or shared."""
    from gymnasium.spaces import Box
    from xuance.torch.agents.multi_agent_rl.maddpg_agents import MADDPG_Agents

    with tempfile.TemporaryDirectory() as folder:
        settings = Namespace(
            agent="MADDPG",
            env_name="none",
            env_id="none",
            learner="MADDPG_Learner",
            policy="MADDPG_Policy",
            representation="Basic_Identical",
            representation_hidden_size=[],
            actor_hidden_size=list(HIDDEN),
            critic_hidden_size=list(HIDDEN),
            activation="relu",
            activation_action="tanh",
            use_parameter_sharing=shared,
            use_actions_mask=False,
            use_rnn=False,
            use_global_state=False,
            use_grad_clip=False,
            grad_clip_norm=0.5,
            distributed_training=False,
            seed=0,
            parallels=1,
            buffer_size=BATCH,
            batch_size=BATCH,
            learning_rate_actor=LR,
            learning_rate_critic=LR,
            gamma=DISCOUNT,
            tau=TAU,
            start_noise=1.0,
            end_noise=0.01,
            sigma=0.1,
            start_training=1,
            training_frequency=1,
            running_steps=10_000_000,
            episode_length=50,
            render=False,
            fps=10,
            device="cpu",
            dl_toolbox="torch",
            logger="tensorboard",
            log_dir=folder,
            model_dir=folder,
        )
        agents = MADDPG_Agents(
            settings,
            num_agents=len(AGENTS),
            agent_keys=list(AGENTS),
            observation_space={agent: Box(-10.0, 10.0, (OBSERVATION,)) for agent in AGENTS},
            action_space={agent: Box(-1.0, 1.0, (ACTION,)) for agent in AGENTS},
        )
        agents.writer.close()
    given = itertools.cycle([_xuances(batch) for batch in batches])
    count = 1 if shared else len(AGENTS)
    return Contestant(
        "xuance",
        count,
        count,
        "a shared critic judges every transition once for each agent" if shared else "",
        lambda: agents.learner.update(next(given)),
    )


def _xuances(batch: Batch) -> dict[str, Any]:
    return {
        "batch_size": BATCH,
        "obs": batch.observations,
        "obs_next": batch.next_observations,
        "actions": batch.actions,
        "rewards": batch.rewards,
        "terminals": {agent: np.zeros(BATCH, dtype=np.float32) for agent in AGENTS},
        "agent_mask": {agent: np.ones(BATCH, dtype=np.float32) for agent in AGENTS},
    }


# --- TorchRL


def torchrl(batches: list[Batch], *, shared: bool) -> Contestant:
    """`DDPGLoss` and `SoftUpdate`, wired as BenchMARL wires them for its MADDPG.

    There, actors have no targets: the next actions are the present actors'. All actors follow the
    sum of the critics.
    """
    from tensordict.nn import TensorDictModule, TensorDictSequential
    from torchrl.data import Bounded
    from torchrl.modules import MultiAgentMLP, ProbabilisticActor, TanhDelta
    from torchrl.objectives import DDPGLoss, SoftUpdate, ValueEstimators

    group, limits = "robots", torch.ones(len(AGENTS), ACTION)
    network = partial(
        MultiAgentMLP,
        n_agents=len(AGENTS),
        share_params=shared,
        num_cells=list(HIDDEN),
        activation_class=nn.ReLU,
    )
    actor = ProbabilisticActor(
        module=TensorDictModule(
            network(n_agent_inputs=OBSERVATION, n_agent_outputs=ACTION, centralised=False),
            in_keys=[(group, "observation")],
            out_keys=[(group, "param")],
        ),
        spec=Bounded(-limits, limits),
        in_keys=[(group, "param")],
        out_keys=[(group, "action")],
        distribution_class=TanhDelta,
        distribution_kwargs={"low": -limits, "high": limits},
        safe=False,
    )
    critic = TensorDictSequential(
        TensorDictModule(
            lambda seen, said: torch.cat([seen, said], -1),
            in_keys=[(group, "observation"), (group, "action")],
            out_keys=[(group, "joined")],
        ),
        TensorDictModule(
            network(n_agent_inputs=OBSERVATION + ACTION, n_agent_outputs=1, centralised=True),
            in_keys=[(group, "joined")],
            out_keys=[(group, "state_action_value")],
        ),
    )
    loss = DDPGLoss(actor, critic, delay_value=True, loss_function="l2")
    loss.set_keys(
        state_action_value=(group, "state_action_value"),
        reward=(group, "reward"),
        priority=(group, "td_error"),
        done=(group, "done"),
        terminated=(group, "terminated"),
    )
    loss.make_value_estimator(ValueEstimators.TD0, gamma=DISCOUNT)
    targets = SoftUpdate(loss, tau=TAU)
    parameters = {
        "loss_actor": loss.actor_network_params,
        "loss_value": loss.value_network_params,
    }
    adams = {
        name: torch.optim.Adam(list(part.flatten_keys().values()), lr=LR, fused=True)
        for name, part in parameters.items()
    }
    given = itertools.cycle([_torchrls(batch, group) for batch in batches])

    def update() -> Any:
        losses = loss(next(given).clone(recurse=False))
        for name, adam in adams.items():
            losses[name].backward()
            adam.step()
            adam.zero_grad()
        targets.step()
        return {name: losses[name].item() for name in adams}

    count = 1 if shared else len(AGENTS)
    return Contestant("torchrl", count, count, "actors have no targets", update)


def _torchrls(batch: Batch, group: str) -> TensorDict:
    def stacked(parts: dict[str, Any]) -> Tensor:
        return torch.stack([torch.from_numpy(parts[agent]) for agent in AGENTS], 1)

    size = (BATCH, len(AGENTS))
    goes_on = torch.zeros(*size, 1, dtype=torch.bool)
    now = {"observation": stacked(batch.observations), "action": stacked(batch.actions)}
    later = {
        "observation": stacked(batch.next_observations),
        "reward": stacked(batch.rewards).unsqueeze(2),
        "done": goes_on,
        "terminated": goes_on,
    }
    following = TensorDict({group: TensorDict(later, size)}, (BATCH,))
    return TensorDict({group: TensorDict(now, size), "next": following}, (BATCH,))
