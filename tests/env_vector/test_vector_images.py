"""Images through shared memory."""

from __future__ import annotations

import numpy as np
from vector_tasks import digest, random_actions, roll


def test_images_are_the_same_from_any_process(vec):
    hashes = set()
    for workers in (0, 1, 2):
        env = vec(2, workers, cameras=("front",))
        seen = roll(env, random_actions(env, 6), seed=3)
        hashes.add(digest(seen))
        observations, _ = seen[0]
        assert observations in env.observation_space
        for agent in env.agents:
            images = observations[agent]["front.rgb"]
            assert images.shape == (2, 16, 24, 3)
            assert images.dtype == np.uint8
            assert images.std() > 0.0
        final = seen[10][4]["final_obs"][1]["left"]
        assert final["front.rgb"].shape == (16, 24, 3)
        env.close()
    assert len(hashes) == 1
