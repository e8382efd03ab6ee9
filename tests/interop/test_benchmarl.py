"""BenchMARL trains on our tasks; run by tests/interop/benchmarl.sh, which has an older TorchRL."""

from __future__ import annotations

import pytest

pytest.importorskip("benchmarl")

import benchmarl_task
import torch


@pytest.mark.parametrize("algorithm", sorted(benchmarl_task.ALGORITHMS))
@pytest.mark.parametrize("task", ["handover", "relay_line"])
def test_an_iteration_of_an_algorithm(task, algorithm):
    experiment = benchmarl_task.main(task, algorithm, iterations=1)
    assert experiment.n_iters_performed == 1
    assert experiment.total_frames == 2 * experiment.max_steps
    weights = [*experiment.policy.parameters()]
    assert weights
    assert all(torch.isfinite(each).all() for each in weights)
