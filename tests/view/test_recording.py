"""Episodes are recorded with the poses of all links and the state of the conditions."""

from __future__ import annotations

from contextlib import closing

import numpy as np
import pytest

from taskbuilder import Expert, parallel_env
from taskbuilder.geometry import from_rpy_deg, to_rpy_deg
from taskbuilder.rollout.players import HoldStill
from taskbuilder.view.contacts import METRES_PER_NEWTON
from taskbuilder.view.recording import record
from taskbuilder.world.visible import LinkPoses, visible_links


@pytest.fixture(scope="module")
def handover():
    with closing(parallel_env("handover")) as env:
        yield env


@pytest.fixture(scope="module")
def played(handover):
    shown = []
    with closing(Expert(handover)) as expert:
        return record(handover, "expert", expert, 0, shown.append), shown


def lamp(moment, name):
    return next(lamp for lamp in moment.lamps if lamp.name == name)


def test_every_state_of_the_episode_is_recorded_and_shown_as_it_is_reached(played):
    recording, shown = played
    assert len(recording.moments) == recording.rollout.steps + 1
    assert list(recording.moments) == shown
    assert recording.verdict().startswith("success after")
    assert "stick" in recording.instruction


def test_links_are_where_the_world_has_them(handover, played):
    recording, _ = played
    links = {link.name: link for link in visible_links(handover.episode.world)}
    assert {"left.wrist_3_link", "right.gripper", "stick", "table.top", "goal"} <= set(links)
    world = handover.episode.world
    last = recording.moments[-1].poses
    np.testing.assert_allclose(last[links["stick"].row, :3], world.position("stick"), atol=1e-6)
    first = recording.moments[0].poses
    assert np.linalg.norm(last - first, axis=1)[links["stick"].row] > 0.1
    assert (last[links["table.top"].row] == first[links["table.top"].row]).all()


def test_lamps_say_what_is_missing_and_what_holds(played):
    recording, _ = played
    begun, ended = recording.moments[0], recording.moments[-1]
    assert not lamp(begun, "success").on
    assert "right does not hold it" in lamp(begun, "success").figure
    assert "cm, within 5 cm is needed" in lamp(begun, "at_goal").figure
    assert lamp(ended, "success").on
    assert "right holds it" in lamp(ended, "success").figure
    assert "cm, within 5 cm is needed" in lamp(ended, "success").figure


def test_stages_are_not_shown_twice(handover, played):
    names = [lamp.name for lamp in played[0].moments[0].lamps]
    assert not set(names) & set(handover.task.description.stages)
    assert len(names) == len(set(names))


def test_an_episode_without_success_says_why(handover):
    verdict = record(handover, "hold", HoldStill(), 0).verdict()
    assert verdict.startswith("no success: Held(stick, by=right)")


def test_poses_are_read_anew(handover):
    handover.reset(seed=1)
    poses = LinkPoses(handover.episode.world)
    before = poses.now()
    handover.reset(seed=2)
    assert not np.array_equal(before, poses.now())


@pytest.mark.parametrize("rpy", [(10, 20, 30), (-170, 80, 170), (0, 90, 40), (0, -90, -40)])
def test_roll_pitch_and_yaw_lead_back_to_the_rotation(rpy):
    quaternion = from_rpy_deg(rpy)
    again = from_rpy_deg(to_rpy_deg(quaternion))
    assert abs(np.dot(quaternion, again)) == pytest.approx(1.0, abs=1e-12)


def test_contacts_have_the_names_of_both_links_and_their_force(touch):
    with closing(parallel_env(str(touch))) as env:
        recording = record(env, "hold", HoldStill(), 0)
    contacts = recording.moments[-1].contacts
    assert contacts.forces["world.floor", "cube"] == pytest.approx(0.1 * 9.81, rel=0.05)
    begin, end = contacts.lines[:, 0], contacts.lines[:, 1]
    assert abs(begin[:, 2]) == pytest.approx(0.0, abs=1e-3)
    lengths = ((end - begin) ** 2).sum(axis=1) ** 0.5
    assert lengths.sum() == pytest.approx(0.1 * 9.81 * METRES_PER_NEWTON, rel=0.05)
