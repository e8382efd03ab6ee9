"""People steer robots of Handover by keys, and what they do is recorded and replays to the bit."""

from __future__ import annotations

from contextlib import closing

import numpy as np
import pytest

from taskbuilder import load_dataset, load_task, multiply
from taskbuilder.data.checking import check_dataset
from taskbuilder.data.growing import GrowingDataset
from taskbuilder.errors import UsageError
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.steering.session import Session, State, steering_plan
from taskbuilder.steering.steering import Steering

from .conftest import Person, above, take_stick


@pytest.fixture(scope="module")
def task():
    return load_task("handover")


@pytest.fixture
def session_of(task, tmp_path):
    """Makes sessions that record into a folder."""
    made = []

    def make(folder="data"):
        plan = steering_plan(task, "expert", Catalogue.discover())
        dataset = GrowingDataset(plan, tmp_path / folder, task)
        made.append(Session(task, Steering(task.agents), dataset=dataset))
        return made[-1]

    yield make
    for session in made:
        session.close()


@pytest.fixture
def recorded(session_of):
    """A session that records."""
    return session_of()


@pytest.fixture
def session(task):
    """A session that records nothing."""
    with closing(Session(task, Steering(task.agents))) as made:
        yield made


def finish(session, steps=150):
    for _ in range(steps):
        if session.state == State.RUNNING:
            session.step()
    assert session.state == State.ENDED


def test_two_people_hand_the_stick_over(recorded, tmp_path):
    recorded.begin("expert", 0)
    left = Person(recorded, "a", "left", "Anna")
    right = Person(recorded, "b", "right", "Ben")
    take_stick(recorded, left)
    right.go(above(recorded, "stick.right_end", 0.08))
    right.go(above(recorded, "stick.right_end"))
    right.grip()
    left.grip()
    goal = recorded.env.episode.world.position("goal")
    left.go(lambda: (goal[0] - 0.38, goal[1], goal[2] + 0.1), 30)
    right.go(lambda: (goal[0] + 0.09, goal[1], goal[2]))
    finish(recorded)
    assert recorded.data.about["success"]
    recorded.keep()
    recorded.close()

    (episode,) = load_dataset(tmp_path / "data")
    assert episode.policy == "human"
    assert episode.operators == ("Anna", "Ben")
    assert {robot: set(rows) for robot, rows in episode.steered_by.items()} == {
        "left": {1},
        "right": {2},
    }
    # The stages of the expert were done in order, so that they are labelled.
    assert [part["stage"] for part in episode.subtasks] == [1, 2, 3, 4, 5, 6]
    assert all(part["done"] for part in episode.subtasks)
    assert list(episode.arrays["stage"][[0, -1]]) == [0, 5]
    checked = check_dataset(tmp_path / "data", 1.0)
    assert checked.ok
    assert checked.replayed == (episode.name,)

    (other,) = multiply(tmp_path / "data", tmp_path / "many", episodes=1, jobs=1)
    assert other.success
    assert other.about["source"] == episode.name


def test_the_expert_does_its_part_beside_a_person(session):
    session.begin("expert", 1)
    left = Person(session, "a", "left")
    take_stick(session, left)
    world = session.env.episode.world
    for _ in range(60):
        if not world.held("stick", "right"):
            session.step()
    left.grip()
    left.go(lambda: (-0.3, 0.0, 0.7), 12)
    finish(session)
    assert session.data.about["success"]
    labels = session.data.arrays["agents/right/operator"]
    assert set(labels) == {0}


def test_a_person_intervenes_and_gives_the_robot_back(session):
    session.begin("expert", 0)
    session.step()
    Person(session, "a", "left", "Anna").go(lambda: (-0.3, 0.1, 0.6), 5)
    session.steering.let_go("a")
    finish(session)
    about = session.data.about
    assert about["success"]  # the expert began the stage again from where the person left the arm
    labels = session.data.arrays["agents/left/operator"]
    assert list(np.flatnonzero(labels == 1)) == list(range(1, 1 + int((labels == 1).sum())))
    assert about["player"] == "expert"


def test_without_people_the_player_is_the_policy(session):
    session.begin("hold", 0)
    session.step()
    session.finish()
    assert session.data.about["policy"] == "hold"
    assert not [name for name in session.data.arrays if name.endswith("/operator")]


def test_a_robot_whose_person_leaves_stands_still_until_another_takes_it(session):
    session.begin("expert", 0)
    Person(session, "a", "left", "Anna").go(lambda: (-0.3, 0.1, 0.6), 3)
    session.steering.leave("a")
    for _ in range(6):
        session.step()
    before = session.env.episode.world.position("left.tcp")
    for _ in range(4):
        session.step()
    assert session.env.episode.world.position("left.tcp") == pytest.approx(before, abs=1e-3)
    assert session.people()["left"] == "stands still, its person has left"
    session.steering.take("b", "left", "Ben")
    session.step()
    session.finish()
    labels = session.data.arrays["agents/left/operator"].tolist()
    assert labels[:3] == [1, 1, 1]
    assert labels[3:-1] == [-1] * 10
    assert labels[-1] == 2


def test_a_robot_of_another_person_is_refused_with_the_name(session):
    session.steering.take("a", "left", "Anna")
    with pytest.raises(UsageError, match="left is steered by Anna; choose another robot"):
        session.steering.take("b", "left", "Ben")
    session.steering.take("a", "right")  # and lets go of the left one
    assert session.steering.take("b", "left", "Ben").name == "Ben"


def test_an_episode_is_discarded_and_tried_again(recorded, tmp_path):
    seed = recorded.begin("hold", 4)
    recorded.step()
    assert recorded.discard() == seed == 4
    assert recorded.state == State.IDLE
    assert recorded.discard() is None
    assert recorded.begin("hold", 4) == 4
    recorded.step()
    recorded.keep()
    assert recorded.begin("hold", 4) == 5  # the data set has an episode of seed 4
    assert len(load_dataset(tmp_path / "data")) == 1


def test_a_session_goes_on_with_the_data_set_of_an_earlier_one(session_of, tmp_path):
    for seed in range(2):
        with closing(session_of()) as session:
            assert session.begin("hold", 0) == seed
            session.step()
            session.keep()
    dataset = load_dataset(tmp_path / "data")
    assert [episode.seed for episode in dataset] == [0, 1]
    assert not dataset[0].success


@pytest.mark.usefixtures("recorded")
def test_two_sessions_do_not_record_into_one_folder(session_of):
    with pytest.raises(UsageError, match="another process"):
        session_of()


def test_a_data_set_that_was_collected_otherwise_is_refused(task, tmp_path):
    with closing(
        GrowingDataset(steering_plan(task, "expert", Catalogue.discover()), tmp_path, task)
    ):
        pass
    other = steering_plan(task, "expert", Catalogue.discover(), horizon=40)
    with pytest.raises(UsageError, match=r"begun in another way[\s\S]*options"):
        GrowingDataset(other, tmp_path, task)


def test_torques_cannot_be_steered(tmp_path):
    text = load_task("handover").file.entry.file.read_text()
    file = tmp_path / "handover.yaml"
    file.write_text(
        text.replace("model: ur5e\n", "model: ur5e\n      action: {arm: joint_torque}\n", 1)
    )
    file.with_suffix(".py").write_text(
        load_task("handover").file.entry.file.with_suffix(".py").read_text()
    )
    task = load_task(file)
    with (
        closing(Session(task, Steering(task.agents))) as session,
        pytest.raises(UsageError, match=r"left cannot be steered: .*commands torques"),
    ):
        session.begin("hold", 0)
