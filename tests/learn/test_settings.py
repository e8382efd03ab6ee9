"""Settings of algorithms: their ranges stand at the fields, and mistakes are named."""

from __future__ import annotations

from dataclasses import fields

import pytest

pytest.importorskip("torch")

from taskbuilder.errors import UsageError
from taskbuilder.learn.algorithms import ALGORITHMS, find_algorithm
from taskbuilder.learn.settings import make_settings, read_settings

MADDPG = find_algorithm("maddpg").settings


@pytest.mark.parametrize("name", ALGORITHMS)
def test_defaults_and_presets_are_in_range(name):
    algorithm = find_algorithm(name)
    defaults = {each.name: each.default for each in fields(algorithm.settings)}
    assert make_settings(algorithm.settings, defaults) == algorithm.settings()
    for preset in algorithm.presets.values():
        make_settings(algorithm.settings, preset.settings)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("batch=0", "batch is 0; at least 1"),
        ("discount=1.5", "discount is 1.5; at most 1.0"),
        ("lr=0", "lr is 0; above 0.0"),
        ("noise=-0.1", "noise is -0.1; at least 0.0"),
        ("noise=much", 'noise is "much"; something like 0.25'),
        ("batch=1.5", 'batch is "1.5"; something like 128'),
        ("batch=true", 'batch is "true"; something like 128'),
        ("share=1", 'share is "1"; something like true'),
        ("hidden=[64,0]", 'hidden is "[64, 0]"; something like [128, 128]'),
        ("hidden=64", 'hidden is "64"; something like [128, 128]'),
        ("lr=NaN", 'lr is "NaN"; something like 0.0003'),
        ("noise", '"noise" sets nothing; write noise=0.25'),
        ("nois=1", 'no setting "nois"; did you mean "noise"?'),
    ],
)
def test_a_wrong_setting_is_refused_and_named(text, says):
    with pytest.raises(UsageError) as error:
        read_settings(MADDPG, [text])
    assert says in str(error.value)


def test_settings_are_read_from_texts_and_mappings():
    assert read_settings(MADDPG, ["hidden=[8]", "noise=1"]) == {"hidden": (8,), "noise": 1.0}
    assert read_settings(MADDPG, {"hidden": [8], "noise": 1}) == {"hidden": (8,), "noise": 1.0}


def test_a_setting_given_twice_is_refused_unless_it_is_the_same():
    assert read_settings(MADDPG, ["noise=0.2", "noise=0.2"]) == {"noise": 0.2}
    with pytest.raises(UsageError, match=r"noise is given twice, as 0\.2 and 0\.3; give it once"):
        read_settings(MADDPG, ["noise=0.2", "noise=0.3"])


def test_a_former_name_is_read_with_a_warning():
    with pytest.warns(FutureWarning, match="the setting cloning is called bc_updates now"):
        assert read_settings(MADDPG, ["cloning=7"]) == {"bc_updates": 7}
    with pytest.warns(FutureWarning, match="judging is called critic_warmup_updates"):
        assert make_settings(MADDPG, {"judging": 9}).critic_warmup_updates == 9
