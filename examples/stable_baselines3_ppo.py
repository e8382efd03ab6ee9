"""Stable-Baselines3: one PPO policy moves both arms of the handover."""

import gymnasium
import torch
from stable_baselines3 import PPO

import taskbuilder.gym

gymnasium.register_envs(taskbuilder.gym)


def main(steps: int = 100_000) -> PPO:
    """Learn for some control steps."""
    torch.set_num_threads(1)  # small networks: more threads are slower
    env = gymnasium.make("taskbuilder/Handover-v1")
    model = PPO("MlpPolicy", env, n_steps=500, batch_size=100, seed=0, device="cpu")
    model.learn(steps)
    env.close()
    return model


if __name__ == "__main__":
    main()
