"""LeRobot loads an exported data set, trains on it, and evaluates what it trained."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from lerobot.configs.recipe import TrainingRecipe
from lerobot.datasets.language_render import render_sample
from lerobot.datasets.lerobot_dataset import LeRobotDataset
from lerobot.envs import utils
from lerobot.envs.factory import make_env
from lerobot.policies.act.modeling_act import ACTPolicy
from lerobot.policies.factory import make_pre_post_processors
from lerobot.processor import PolicyProcessorPipeline
from lerobot.scripts.lerobot_eval import eval_policy

from taskbuilder import load_dataset

EXAMPLES = Path(__file__).resolve().parents[3] / "examples"
NAME = "taskbuilder/handover"
DECODER = "pyav"  # LeRobot's own choice, torchcodec, needs the libraries of an FFmpeg in the system
SMALL = {  # of ACT, so that steps take a second
    "pretrained_backbone_weights": "null",
    "dim_model": 64,
    "dim_feedforward": 64,
    "n_heads": 2,
    "n_encoder_layers": 1,
    "chunk_size": 10,
    "n_action_steps": 10,
    "use_vae": "false",
    "device": "cpu",
    "push_to_hub": "false",
}


@pytest.fixture(scope="module")
def exported(export):
    return export("lerobot")


@pytest.fixture(scope="module")
def checkpoint(exported, tmp_path_factory):
    """What LeRobot's own command trained in 200 steps."""
    out = tmp_path_factory.mktemp("trained") / "act"
    words = [f"--dataset.repo_id={NAME}", f"--dataset.root={exported}", "--policy.type=act"]
    words += [f"--policy.{name}={value}" for name, value in SMALL.items()]
    words += [f"--dataset.video_backend={DECODER}"]
    words += ["--batch_size=2", "--steps=200", "--num_workers=0", "--log_freq=50"]
    said = lerobot("lerobot_train", *words, f"--output_dir={out}", "--wandb.enable=false")
    assert "loss:" in said
    return out / "checkpoints" / "last" / "pretrained_model"


def lerobot(script, *words):
    """Runs a command of LeRobot and returns what it says."""
    command = [sys.executable, "-m", f"lerobot.scripts.{script}", *words]
    surroundings = {**os.environ, "HF_HUB_OFFLINE": "1", "PYTHONPATH": str(EXAMPLES)}
    ran = subprocess.run(command, env=surroundings, capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr[-4000:]
    return ran.stdout + ran.stderr


def test_numbers_and_pictures_are_those_that_were_recorded(recorded, exported):
    loaded = LeRobotDataset(NAME, root=exported, video_backend=DECODER)
    episodes = load_dataset(recorded)
    assert loaded.num_episodes == len(episodes)
    assert loaded.num_frames == sum(episode.steps for episode in episodes)
    row = 0
    for episode in episodes:
        for step in (0, episode.steps // 2, episode.steps - 1):
            frame = loaded[row + step]
            joined = np.concatenate([episode.actions[a][step] for a in episode.actions])
            np.testing.assert_array_equal(frame["action"].numpy(), joined.astype(np.float32))
            for camera in ("front", "left_wrist"):
                shown = frame[f"observation.images.{camera}"].numpy().transpose(1, 2, 0)
                assert np.abs(shown * 255.0 - episode.images(camera)[step]).max() < 0.01
            assert frame["task"] == episode.instruction
        row += episode.steps


def test_sub_tasks_are_what_its_recipes_find(recorded, exported):
    """At every frame, `${subtask}` is the label of the stage that was under way."""
    loaded = LeRobotDataset(NAME, root=exported, video_backend=DECODER)
    assert loaded.meta.has_language_columns
    said = [{"role": "assistant", "content": "${subtask}", "stream": "low_level", "target": True}]
    recipe = TrainingRecipe.from_dict({"messages": said})
    row = 0
    for episode in load_dataset(recorded):
        for part in episode.subtasks:
            for step in (part["from_step"], part["to_step"] - 1):
                frame = loaded.hf_dataset[row + step]
                rendered = render_sample(
                    recipe=recipe,
                    persistent=frame["language_persistent"],
                    events=[],
                    t=frame["timestamp"].item(),
                    sample_idx=row + step,
                )
                assert rendered["messages"][0]["content"] == part["label"]
        row += episode.steps


def test_it_trains_a_policy(checkpoint):
    about = json.loads((checkpoint / "config.json").read_text())
    assert set(about["input_features"]) == {
        "observation.state",
        "observation.images.front",
        "observation.images.left_wrist",
    }


def test_its_evaluation_plays_the_policy(checkpoint, tmp_path):
    words = ["--env.discover_packages_path=lerobot_taskbuilder", "--env.type=taskbuilder"]
    words += ["--env.task=handover", "--env.cameras=[front,left_wrist]"]
    words += ["--env.camera_size=[96,96]", f"--policy.path={checkpoint}", "--policy.device=cpu"]
    words += ["--eval.n_episodes=2", "--eval.batch_size=2", f"--output_dir={tmp_path / 'eval'}"]
    lerobot("lerobot_eval", *words)
    result = json.loads((tmp_path / "eval" / "eval_info.json").read_text())
    assert 0.0 <= result["overall"]["pc_success"] <= 100.0
    assert result["overall"]["n_episodes"] == 2


def test_its_evaluation_plays_the_policy_in_the_environment_of_the_data_set(
    checkpoint, exported, monkeypatch
):
    """LeRobot gets env.py from the Hub, whose client finds it here in the exported folder."""
    monkeypatch.setattr(utils, "hf_hub_download", lambda filename, **_: str(exported / filename))
    (env,) = make_env("taskbuilder/policy", n_envs=2, trust_remote_code=True)[
        "taskbuilder"
    ].values()
    policy = ACTPolicy.from_pretrained(checkpoint)
    policy.eval()  # PyTorch: no dropout, as in LeRobot's own evaluation
    before, after = make_pre_post_processors(policy.config, pretrained_path=str(checkpoint))
    none = PolicyProcessorPipeline(steps=[])
    result = eval_policy(env, policy, none, none, before, after, n_episodes=2, start_seed=0)
    assert result["aggregated"]["pc_success"] in (0.0, 50.0, 100.0)
    assert [each["seed"] for each in result["per_episode"]] == [0, 1]
    env.close()
