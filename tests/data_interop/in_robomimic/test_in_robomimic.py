"""robomimic loads an exported data set and trains on it."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest
import robomimic.utils.train_utils as train_utils
import torch
from robomimic.config import config_factory
from robomimic.scripts.train import train
from robomimic.utils import obs_utils

from taskbuilder import load_dataset


@pytest.fixture(scope="module")
def exported(export):
    (file,) = export("robomimic").glob("*.hdf5")
    return file


def config_for(file, out):
    """Behaviour cloning from the states of both robots and a camera."""
    config = config_factory("bc")
    with config.values_unlocked():
        config.experiment.name = "handover"
        config.experiment.validate = True
        config.experiment.epoch_every_n_steps = 5
        config.experiment.validation_epoch_every_n_steps = 2
        config.experiment.rollout.enabled = False
        config.experiment.save.enabled = True
        config.experiment.save.every_n_epochs = 1
        config.train.data = str(file)
        config.train.output_dir = str(out)
        config.train.num_epochs = 2
        config.train.batch_size = 4
        config.train.num_data_workers = 0
        config.train.cuda = False
        config.train.hdf5_filter_key = "train"
        config.train.hdf5_validation_filter_key = "valid"
        config.observation.modalities.obs.low_dim = ["left_observation", "right_observation"]
        config.observation.modalities.obs.rgb = ["front_image"]
        config.observation.encoder.rgb.core_kwargs.backbone_class = "ResNet18Conv"
        config.observation.encoder.rgb.core_kwargs.backbone_kwargs.pretrained = False
    return config


def test_it_loads_what_was_recorded(recorded, exported, tmp_path):
    config = config_for(exported, tmp_path)
    obs_utils.initialize_obs_utils_with_config(config)
    keys = ["left_observation", "right_observation", "front_image"]
    loaded, _ = train_utils.load_data_for_training(config, obs_keys=keys)
    episode = load_dataset(recorded)[int(loaded.demos[0].removeprefix("demo_"))]
    first = loaded[0]
    joined = np.concatenate([episode.actions[agent][0] for agent in episode.actions])
    np.testing.assert_array_equal(first["actions"][0], joined.astype(np.float32))
    seen = episode.observations["left"][0]
    np.testing.assert_array_equal(first["obs"]["left_observation"][0], seen)
    assert first["obs"]["front_image"].shape[-3:] in {(96, 96, 3), (3, 96, 96)}


def test_it_trains_a_policy(exported, tmp_path):
    config = config_for(exported, tmp_path)
    config.lock()
    train(config, device=torch.device("cpu"))
    (log,) = tmp_path.rglob("log.txt")
    losses = re.findall(r'"Loss": ([-+.e\d]+)', log.read_text())
    assert len(losses) == 4  # of training and validation, in two epochs
    assert all(math.isfinite(float(loss)) for loss in losses)
    assert list(tmp_path.rglob("model_epoch_2*.pth"))
