"""Each check fails on a task that is made to fail it, and only then."""

from __future__ import annotations

import math

import pytest

pytestmark = pytest.mark.in_process

CUBE = "place: {center: [0.5, 0, 0.0205], size: [0.1, 0.1, 0]}"
SHELF = """place: {surface: shelf, in: shelf, WHERE}
    shelf:
      parts:
        left: {box: [0.1, 0.2, 0.1], at: [-0.1, 0, 0]}
        right: {box: [0.1, 0.2, 0.1], at: [0.1, 0, 0]}
      fixed: true
      position: [0.5, 0, 0.05]
"""


def on_shelf(where):
    """The cube is placed on two posts with a gap between them."""
    return [(CUBE, SHELF.replace("WHERE", where))]


SUCCESS = 'Above("cube", height=0.2)'
OWN = "\n\n@condition\ndef own(world):\n    {}\n\n\nclass Small"

# What is wrong -> the changes, the code, the family in which it shows.
WRONG = {
    "home out of reach": (
        [("[0, 0, 0]}}", "[0, 0, 0]}, home: {tcp: {position: [3, 0, 0.5]}}}")],
        "TB303",
        "build",
    ),
    "one inside another": ([(CUBE, "position: [0.05, 0, 0.05]")], "TB304", "build"),
    "sunk in the floor": ([(CUBE, "position: [0.5, 0, 0.005]")], "TB304", "build"),
    "taken region": ([("[0.5, 0, 0.0205]", "[0, 0, 0.1]")], "TB305", "build"),
    "in the air": ([(CUBE, "position: [0.5, 0, 0.5]")], "TB306", "build"),
    "falls off the world": ([(CUBE, "position: [0.5, 0, -47]")], "TB307", "build"),
    "camera turned away": ([("look_at: [0, 0, 0.3]", "look_at: [0, -4, 1]")], "TB309", "build"),
    "leaves its region": ([("0.0205]", "0.03]")], "TB310", "reset"),
    "over an edge": (on_shelf("center: [0.1, 0.1], size: [0.02, 0.1]"), "TB318", "reset"),
    "tips over": (
        on_shelf("center: [0.1, 0], size: [0.02, 0.02], rpy_deg: [30, 0, 0]"),
        "TB310",
        "reset",
    ),
    "solved": ([("height=0.2", "height=0.01")], "TB311", "reset"),
    "failed": ([("height=-0.1", "height=0.1")], "TB312", "reset"),
    "does not vary": (
        [
            (
                "goal: {position: [0.5, 0, 0.3]}",
                "goal: {place: {center: [0, 0, 1], size: [1e-9, 0, 0]}}",
            )
        ],
        "TB313",
        "reset",
    ),
    "raises": (
        [("\n\nclass Small", OWN.format("return 1 / 0")), (SUCCESS, "own()")],
        "TB314",
        "reset",
    ),
    "exits": (
        [("\n\nclass Small", OWN.format("raise SystemExit(3)")), (SUCCESS, "own()")],
        "TB314",
        "reset",
    ),
}


@pytest.mark.parametrize("what", WRONG)
def test_a_check_fails_on_a_task_made_to_fail_it(what, validate):
    changes, code, family = WRONG[what]
    report = validate(*changes)
    assert not report.ok
    assert {finding.code for finding in report.findings} == {code}
    assert [result.name for result in report.families if not result.ok] == [family]
    assert {c.code for f in report.families for c in f.checks if not c.ok} <= {code}


@pytest.mark.parametrize("what", WRONG)
def test_a_finding_points_into_the_file_that_is_wrong(what, validate):
    (finding, *_) = validate(*WRONG[what][0]).findings
    assert finding.location.line > 0
    assert finding.location.file.suffix == (".py" if finding.code in _OF_DESCRIPTIONS else ".yaml")


_OF_DESCRIPTIONS = ("TB311", "TB312", "TB314")


def test_a_sound_task_fails_no_check(validate):
    report = validate()
    assert report.ok
    assert report.findings == ()
    checks = [check for family in report.families for check in family.checks]
    assert all(check.ok for check in checks)
    expected = {code for _, code, _ in WRONG.values()} - {"TB303"} | {"TB308"}
    assert {check.code for check in checks} >= expected


def test_every_figure_is_on_the_right_side_of_its_limit(validate):
    for family in validate().families:
        for check in family.checks:
            assert check.value is not None
            assert math.isfinite(check.value)
            if check.limit is not None and check.code not in ("TB309", "TB313"):
                assert check.value <= check.limit, check
            elif check.limit is not None:
                assert check.value >= check.limit, check


@pytest.mark.parametrize("mass", ["200", "0.0002"])
def test_an_implausible_mass_is_a_warning_and_fails_nothing(mass, validate):
    report = validate(("mass: 0.1", f"mass: {mass}"))
    assert report.ok
    (finding,) = report.findings
    assert (finding.code, finding.severity) == ("TB308", "warning")


class TestLoads:
    """Attached objects that the fingers could not hold by friction."""

    HEAVY = ("mass: 0.1", "mass: 40")
    BIG = ("box: [0.04, 0.04, 0.04]", "box: [0.3, 0.3, 0.3]")
    HIGHER = ("[0.5, 0, 0.0205]", "[0.5, 0, 0.1505]")

    def arm(self, grasp):
        return ("{model: ur5e, base", f"{{model: ur5e, grasp: {grasp}, base")

    def test_what_fingers_could_not_hold_is_a_warning_with_what_they_could(self, validate):
        report = validate(self.HEAVY, self.BIG, self.HIGHER, self.arm("attach"))
        (finding,) = report.findings
        assert report.ok
        assert (finding.code, finding.severity) == ("TB319", "warning")
        assert finding.path == "scene.objects.cube.mass"
        most = 2 * 20.0 * 1.2 * 0.8 / 9.81  # two fingers, their friction, and that of the cube
        assert "cube weighs 40 kg, and arm attaches it, whatever the load; " in finding.message
        assert f"up to {most:.2g} kg could be held" in finding.message
        assert finding.message.endswith("grasp: {rule: attach, force: 38}")

    @pytest.mark.parametrize(
        ("grasp", "mass"),
        [
            ("attach", "mass: 3.8"),
            ("{rule: attach, force: 38}", "mass: 40"),
            ("friction", "mass: 40"),
        ],
    )
    def test_a_light_load_a_limit_and_friction_are_fine(self, validate, grasp, mass):
        heavy = (self.HEAVY[0], mass)
        assert validate(heavy, self.BIG, self.HIGHER, self.arm(grasp)).findings == ()


def test_a_placeholder_of_an_inertia_is_a_warning_and_the_factor_is_measured(validate):
    shape = "{urdf: package://pybullet_data/lego/lego.urdf}"
    brick = f"    brick: {{shape: {shape}, position: [2, 0, 0.012]}}"
    report = validate(("  sites:\n", f"{brick}\n  sites:\n"), only=("build",))
    (finding,) = [finding for finding in report.findings if finding.code == "TB422"]
    (check,) = [c for family in report.families for c in family.checks if c.code == "TB422"]
    assert finding.severity == "warning"
    assert check.value == pytest.approx(77_270, rel=1e-3)


def test_bodies_that_overlap_are_told_before_the_physics_throws_them_apart(validate):
    table = "    table: {shape: {box: [1, 1, 0.4]}, fixed: true, position: [0, 0, 0.2]}\n"
    report = validate(("  sites:\n", f"{table}  sites:\n"), (CUBE, "position: [2, 0, 0.02]"))
    assert {finding.code for finding in report.findings} == {"TB304"}


def test_a_fault_of_one_variation_names_it(validate):
    report = validate(
        add="variations:\n  - {cube.color: green}\n  - {cube.place.center: [0.5, 0, 2]}\n"
    )
    (finding,) = [f for f in report.findings if f.code != "TB310"]
    assert (finding.code, finding.path) == ("TB306", "scene.objects.cube")
    assert finding.message.startswith("in variation 2: ")


def test_a_fault_of_all_variations_is_told_once(validate):
    report = validate(
        (CUBE, "position: [0.5, 0, 0.5]"), add="variations:\n  - {cube.color: green}\n"
    )
    assert [finding.message[:4] for finding in report.findings] == ["cube"]


def test_success_at_the_start_names_seed_and_variation(validate):
    changed = "variations:\n  - {goal.position: [0.5, 0, 0.02]}\n"
    near = ('Above("cube", height=0.2)', 'Above("cube", "goal", height=-0.01)')
    report = validate(near, add=changed)
    (finding,) = report.findings
    assert "at the start of 3 of 6 episodes (seed 0, variation 1)" in finding.message


class TestRegionsOnSurfaces:
    """What is placed on a surface stays on it."""

    def found(self, validate, where, **options):
        return validate(*on_shelf(where), only=("reset",), **options).findings

    def test_the_region_that_the_finding_suggests_is_right(self, validate):
        over = "center: [0.1, 0.1], size: [0.02, 0.1]"
        (finding,) = self.found(validate, over)
        assert finding.path == "scene.objects.cube.place"
        assert "the region reaches 5.0 cm over the edge of shelf" in finding.message
        right = "center: [0.1, 0.07], size: [0.02, 0.04]"
        assert finding.message.endswith(f"on it, the largest is {right}")
        assert not self.found(validate, right)

    def test_a_region_far_beside_its_surface_has_no_part_on_it(self, validate):
        (finding,) = self.found(validate, "center: [0.1, 1], size: [0.02, 0.1]")
        assert finding.message.endswith("move its center, or make it smaller")

    def test_every_seed_finds_it(self, validate):
        (finding,) = self.found(validate, "center: [0.1, 0.06], size: [0.02, 0.09]", seeds=1)
        assert finding.code == "TB318"

    def test_it_says_how_often_the_object_fell(self, validate):
        (finding,) = self.found(validate, "center: [0.1, 0.2], size: [0.02, 0.02]", seeds=3)
        assert finding.message.startswith("it fell in 3 of 3 resets; ")

    def test_what_falls_through_a_gap_has_left_its_region(self, validate):
        (finding,) = self.found(validate, "center: [0, 0], size: [0.01, 0.1]", seeds=2)
        assert finding.code == "TB310"
        assert finding.message == "fell from shelf in 2 of 2 resets"

    def test_a_region_may_go_over_to_what_stands_beside_as_high(self, validate):
        where = "center: [0.1, 0.1], size: [0.02, 0.1]"
        beside = (
            "    other: {shape: {box: [0.3, 0.2, 0.1]}, fixed: true, position: [0.5, 0.2, 0.05]}"
        )
        (change,) = on_shelf(where)
        beside = (change[0], f"{change[1]}{beside}\n")
        assert not validate(beside, only=("reset",)).findings

    def test_it_may_go_as_far_as_the_edge(self, validate):
        assert not self.found(validate, "center: [0.1, 0.05], size: [0.02, 0.1]", seeds=1)


LEANING = """<robot name="leaning"><link name="body">
  <inertial><mass value="0.2"/><origin xyz="{center}"/>
    <inertia ixx="2e-4" iyy="2e-4" izz="2e-4" ixy="0" ixz="0" iyz="0"/></inertial>
  <collision><origin xyz="0 0 0.03" rpy="{roll} 0 0"/><geometry><box size="0.06 0.06 0.06"/>
  </geometry></collision></link></robot>
"""


class TestWhatDoesNotStandUpright:
    """An object of others, whose own frame or centre of mass is not what one would expect."""

    def found(self, validate, tmp_path, where="", more="", **shape):
        (tmp_path / "leaning.urdf").write_text(LEANING.format(**shape))
        thing = (
            f"    thing: {{shape: {{urdf: leaning.urdf}}, {more} place: {{surface: board, "
            f"center: [0.5, 0.5], size: [0.02, 0.02]{where}}}}}\n    board: {{shape: {{box: "
            "[0.4, 0.4, 0.1]}, fixed: true, position: [0.5, 0.5, 0.05]}\n"
        )
        report = validate(("  objects:\n", f"  objects:\n{thing}"), only=("reset",), seeds=2)
        return [one.message for one in report.findings if one.code == "TB310"]

    def test_it_tilts_and_the_orientation_in_which_it_lies_is_named(self, validate, tmp_path):
        shape = {"center": "0 0 0.03", "roll": math.radians(12)}
        (message,) = self.found(validate, tmp_path, **shape)
        assert message.startswith("tilted by ")
        assert message.endswith(
            "° on board in 2 of 2 resets; it comes to lie with rpy_deg: [-12, 0, 0], so write that "
            "under place"
        )
        assert not self.found(validate, tmp_path, ", rpy_deg: [-12, 0, 0]", **shape)

    def test_a_centre_of_mass_that_makes_it_tip_is_named(self, validate, tmp_path):
        shape = {"center": "0.045 0 0.05", "roll": 0}
        (message,) = self.found(validate, tmp_path, **shape)
        assert message.startswith("tilted by ")
        assert "the centre of mass that the URDF gives body is 49 mm from that of its" in message
        assert message.endswith("write inertia: shape for the object")
        assert not self.found(validate, tmp_path, more="inertia: shape,", **shape)


CABINET = """<robot name="cabinet">
  <link name="case"><inertial><mass value="2"/>
    <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="door"><inertial><mass value="0.2"/>
    <inertia ixx="0.001" iyy="0.001" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><box size="0.1 0.01 0.1"/></geometry></collision></link>
  <link name="drawer"><inertial><mass value="0.2"/>
    <inertia ixx="0.001" iyy="0.001" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><origin xyz="0 0 0.2"/><geometry><box size="0.1 0.1 0.05"/></geometry></collision>
  </link>
  <joint name="hinge" type="revolute"><parent link="case"/><child link="door"/><axis xyz="0 0 1"/>
    <limit lower="0" upper="1.5708" effort="5" velocity="1"/></joint>
  <joint name="runner" type="prismatic"><parent link="case"/><child link="drawer"/>
    <axis xyz="0 1 0"/><limit lower="0" upper="0.2" effort="5" velocity="1"/></joint>
</robot>
"""


HINGE, RUNNER = 'JointAngle("cabinet.hinge",', 'JointPosition("cabinet.runner",'


class TestJointsWithinTheirLimits:
    """A description wants of a joint only what its limits allow."""

    def found(self, validate, tmp_path, success, joints="{}", more=""):
        (tmp_path / "cabinet.urdf").write_text(CABINET)
        cabinet = "    cabinet: {shape: {urdf: cabinet.urdf}, fixed: true, position: [1, 0, 0.5], "
        report = validate(
            ("  objects:\n", f"  objects:\n{cabinet}joints: {joints}}}\n"),
            (SUCCESS, success),
            ("import Above, Below,", "import Above, Below, JointAngle, JointPosition, Sustained,"),
            add=more,
            only=("build",),
        )
        return [f for f in report.findings if f.code == "TB302"]

    @pytest.mark.parametrize(
        ("success", "message"),
        [
            (f"{HINGE} above_deg=100)", "needs 100°, and cabinet.hinge is at most 90°"),
            (f"{HINGE} below_deg=-5)", "needs -5°, and cabinet.hinge is at least 0°"),
            (f"{RUNNER} above=0.25)", "needs 0.25 m, and cabinet.runner is at most 0.2 m"),
            (f"Sustained({SUCCESS} & {HINGE} above_deg=100), seconds=0.5)", "needs 100°"),
        ],
    )
    def test_success_that_a_limit_forbids(self, validate, tmp_path, success, message):
        (finding,) = self.found(validate, tmp_path, success)
        assert finding.severity == "error"
        assert message in finding.message
        assert finding.message.endswith("by cabinet.urdf")
        assert finding.location.file.name == "small.py"
        text = finding.location.file.read_text().splitlines()[finding.location.line - 1]
        assert "Joint" in text

    def test_a_limit_of_the_task_file_is_named_by_its_line(self, validate, tmp_path):
        success = f"{HINGE} above_deg=60)"
        (finding,) = self.found(validate, tmp_path, success, "{hinge: {limits_deg: [0, 45]}}")
        assert finding.message.endswith("is at most 45°, by small.yaml:7")

    def test_a_limit_of_a_variation_counts_there(self, validate, tmp_path):
        success = f"{HINGE} above_deg=60)"
        more = "variations:\n  - {cabinet.joints.hinge.limits_deg: [0, 45]}\n"
        joints = "{hinge: {limits_deg: [0, 90]}}"
        (finding,) = self.found(validate, tmp_path, success, joints, more)
        assert finding.message.startswith("in variation 1, can never hold: it needs 60°")

    def test_what_success_does_not_need_is_a_warning(self, validate, tmp_path):
        success = f"{SUCCESS} | {HINGE} above_deg=100)"
        (finding,) = self.found(validate, tmp_path, success)
        assert finding.severity == "warning"

    @pytest.mark.parametrize(
        "success",
        [
            f"{HINGE} above_deg=90)",
            f"{HINGE} below_deg=0)",
            f"{RUNNER} above=0.2)",
        ],
    )
    def test_a_joint_can_be_at_its_limit(self, validate, tmp_path, success):
        assert not self.found(validate, tmp_path, success)
