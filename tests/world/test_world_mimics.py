"""Joints of objects that mimic others follow them, whatever moves either of the two."""

from __future__ import annotations

import pytest

from taskbuilder.env.whole_scene import everything

LINK = """<link name="{name}">
  <inertial><mass value="0.1"/>
    <inertia ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial>
  <collision><geometry><box size="0.05 0.05 0.05"/></geometry></collision>
</link>
"""
JOINT = """<joint name="{name}" type="{kind}">
  <parent link="base"/><child link="{child}"/><origin xyz="0 {y} 0"/><axis xyz="0 1 0"/>
  <limit lower="-1" upper="1" effort="5" velocity="1"/>{mimic}
</joint>
"""
SCENE = """
timing: {control_hz: 20, physics_hz: 240}
scene:
  robots:
    arm: {model: ur5e, base: {position: [-2, 0, 0]}}
  objects:
    vice:
      shape: {urdf: vice.urdf, scale: SCALE}
      fixed: true
      position: [0, 0, 1]
      joints: {JOINTS}
"""
# Stiff enough that a step of 1/240 s is stable.
SPRINGS = {
    "prismatic": "spring: {stiffness: 20, rest: 0.1}, damping: 4, friction: 0",
    "revolute": "spring: {stiffness: 0.5, rest_deg: 10}, damping: 0.05, friction: 0",
}


@pytest.fixture
def vice(build, tmp_path):
    """A world with an object of a joint `lead` and one `follow` that mimics it."""

    def make(kinds, mimic, joints, scale=1):
        lead, follow = kinds
        text = "".join(LINK.format(name=name) for name in ("base", "left", "right"))
        text += JOINT.format(name="follow", kind=follow, child="right", y=-0.2, mimic=mimic)
        text += JOINT.format(name="lead", kind=lead, child="left", y=0.2, mimic="")
        (tmp_path / "vice.urdf").write_text(f'<robot name="vice">{text}</robot>')
        return build(SCENE.replace("JOINTS", joints).replace("SCALE", str(scale)))

    return make


def settled(world, steps=60):
    world.reset(0)
    for _ in range(steps):
        world.step()
    return world.joint("vice.lead"), world.joint("vice.follow")


@pytest.mark.parametrize("driven", ["lead", "follow"])
@pytest.mark.parametrize(
    ("multiplier", "offset"), [(1.0, 0.0), (-1.0, 0.0), (0.5, 0.0), (2.0, 0.05), (-1.5, -0.02)]
)
def test_a_joint_follows_the_one_that_it_mimics(vice, multiplier, offset, driven):
    mimic = f'<mimic joint="lead" multiplier="{multiplier}" offset="{offset}"/>'
    other = "follow" if driven == "lead" else "lead"
    joints = f"{driven}: {{{SPRINGS['prismatic']}}}, {other}: {{friction: 0}}"
    lead, follow = settled(vice(("prismatic", "prismatic"), mimic, joints))
    assert follow == pytest.approx(multiplier * lead + offset, abs=2e-4)
    assert (lead if driven == "lead" else follow) == pytest.approx(0.1, abs=2e-3)


@pytest.mark.parametrize(
    "kinds", [("revolute", "revolute"), ("revolute", "prismatic"), ("prismatic", "revolute")]
)
def test_joints_of_different_kinds_are_coupled(vice, kinds):
    joints = f"lead: {{{SPRINGS[kinds[0]]}}}, follow: {{friction: 0}}"
    world = vice(kinds, '<mimic joint="lead" multiplier="0.7" offset="0.1"/>', joints)
    lead, follow = settled(world)
    assert lead > 0.05
    assert follow == pytest.approx(0.7 * lead + 0.1, abs=2e-4)


def test_it_starts_where_the_other_joint_has_it(vice):
    mimic = '<mimic joint="lead" multiplier="-0.5" offset="0.2"/>'
    world = vice(("prismatic", "prismatic"), mimic, "lead: {start: 0.3}")
    assert (world.joint("vice.lead"), world.joint("vice.follow")) == pytest.approx((0.3, 0.05))


def test_the_scale_of_the_object_is_that_of_its_offset(vice):
    mimic = '<mimic joint="lead" multiplier="2" offset="0.1"/>'
    world = vice(("revolute", "prismatic"), mimic, "lead: {start_deg: 0}", scale=0.5)
    lead, follow = settled(world, steps=1)
    assert follow == pytest.approx(2 * 0.5 * lead + 0.05, abs=1e-4)


def test_a_lock_of_either_holds_both(vice):
    for locked, other in (("lead", "follow"), ("follow", "lead")):
        joints = f"{locked}: {{lock: {{unless: free}}}}, {other}: {{{SPRINGS['prismatic']}}}"
        world = vice(("prismatic", "prismatic"), '<mimic joint="lead"/>', joints)
        assert settled(world) == pytest.approx((0, 0), abs=1e-3)


def test_a_restored_state_goes_on_to_the_bit(vice):
    joints = f"lead: {{{SPRINGS['prismatic']}}}, follow: {{friction: 0.01}}"
    world = vice(("prismatic", "prismatic"), '<mimic joint="lead" multiplier="-1.3"/>', joints)

    def course():
        values = []
        for _ in range(15):
            world.step()
            values.append((world.joint("vice.lead"), world.joint("vice.follow")))
        return values

    settled(world, steps=4)
    state = world.save()
    first = course()
    world.restore(state)
    assert course() == first
    assert len(set(first)) == len(first)


def test_it_is_no_state_of_its_own(vice):
    world = vice(("prismatic", "prismatic"), '<mimic joint="lead"/>', "lead: {friction: 0}")
    channels = everything(world)
    assert "vice.lead" in channels
    assert "vice.follow" not in channels
