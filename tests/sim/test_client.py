from __future__ import annotations

import subprocess
import sys

import pytest

from taskbuilder.errors import SimulationError
from taskbuilder.geometry import Pose
from taskbuilder.shapes import Part, SphereShape
from taskbuilder.sim.bodies import create_body
from taskbuilder.sim.client import Client

BALL = {"ball": Part(SphereShape(0.05))}


def test_importing_and_using_a_client_prints_nothing():
    script = (
        "from taskbuilder.sim.client import Client\n"
        "with Client(physics_hz=120) as client: client.step(3)"
    )
    child = subprocess.run([sys.executable, "-c", script], capture_output=True, check=True)
    assert (child.stdout, child.stderr) == (b"", b"")


def test_importing_the_package_does_not_import_the_engine():
    script = "import sys, taskbuilder.sim; sys.exit('pybullet' in sys.modules)"
    subprocess.run([sys.executable, "-c", script], check=True)


def test_a_dropped_ball_falls_under_gravity():
    with Client(physics_hz=240) as client:
        ball = create_body(client, BALL, mass=1.0)
        client.step(120)
        assert ball.pose().position[2] == pytest.approx(-9.81 / 8, rel=0.03)  # Bullet adds drag


def test_clients_do_not_share_their_worlds():
    with Client(physics_hz=120) as one, Client(physics_hz=60, gravity=(0, 0, 0)) as other:
        falling = create_body(one, BALL, mass=1.0)
        floating = create_body(other, BALL, mass=1.0)
        one.step(10)
        other.step(10)
        assert falling.pose().position[2] < -0.01
        assert floating.pose() == Pose()
        assert (one.dt, other.dt) == (1 / 120, 1 / 60)


def test_a_closed_client_refuses_calls_even_when_its_number_is_used_again():
    client = Client(physics_hz=120)
    ball = create_body(client, BALL, mass=1.0)
    client.close()
    client.close()
    with Client(physics_hz=120), pytest.raises(SimulationError, match="closed"):
        ball.pose()
    with pytest.raises(SimulationError, match="closed"):
        client.step(1)


def test_what_bullet_refuses_is_a_simulation_error(client):
    with pytest.raises(SimulationError, match="getBodyInfo"):
        client.bullet.getBodyInfo(99)


def test_commands_can_be_given_before_each_physics_step(client):
    calls = []
    client.step(3, drives=[iter(lambda: calls.append("command"), "never")])
    assert calls == ["command"] * 3


@pytest.mark.parametrize("rate", [0, -120])
def test_a_rate_that_is_not_positive_is_refused(rate):
    with pytest.raises(SimulationError, match="physics_hz"):
        Client(physics_hz=rate)


def test_finding_contacts_does_not_change_the_trajectory():
    def fall(collide: bool) -> Pose:
        with Client(physics_hz=120) as client:
            create_body(client, {"floor": Part(SphereShape(0.5))}, pose=Pose((0, 0, -0.5)))
            ball = create_body(client, BALL, mass=1.0, pose=Pose((0.02, 0.01, 0.1)))
            for _ in range(200):
                client.step(1)
                if collide:
                    client.collide()
            return ball.pose()

    assert fall(collide=True) == fall(collide=False)
