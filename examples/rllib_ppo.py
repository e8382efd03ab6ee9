"""RLlib: a PPO policy for each arm of the handover."""

from ray.rllib.algorithms.ppo import PPOConfig
from ray.rllib.env.wrappers.pettingzoo_env import ParallelPettingZooEnv
from ray.tune.registry import register_env

import taskbuilder


def main(iterations: int = 50, batch: int = 2000) -> list[float]:
    """Learn for some iterations; the mean return after each."""
    register_env("handover", lambda _: ParallelPettingZooEnv(taskbuilder.parallel_env("handover")))
    config = (
        PPOConfig()
        .environment("handover")
        .multi_agent(policies={"left", "right"}, policy_mapping_fn=lambda agent, *_, **__: agent)
        .env_runners(num_env_runners=0)
        .training(train_batch_size_per_learner=batch, minibatch_size=100, num_epochs=4)
    )
    algorithm = config.build_algo()
    returns = [algorithm.train()["env_runners"]["episode_return_mean"] for _ in range(iterations)]
    algorithm.stop()
    return returns


if __name__ == "__main__":
    main()
