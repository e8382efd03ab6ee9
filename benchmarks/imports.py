"""Importing robots of others: each file before and after, as a table.

    python benchmarks/imports.py FOLDER [--only WORDS] [--out benchmarks/results/imports.json]

FOLDER holds the repositories, named OWNER+NAME, and in pip/ the unpacked wheels of
example-robot-data, airo-models and rtb-data. None of their files is part of this project.
"""

from __future__ import annotations

import argparse
import json
import math
import resource
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from taskbuilder.assets.paths import AssetError, pybullet_data_folder
from taskbuilder.assets.urdf import read_urdf
from taskbuilder.errors import FileError, TaskbuilderError
from taskbuilder.importing.arms import import_arms
from taskbuilder.importing.folders import ImportSource, import_robot
from taskbuilder.importing.mounting import Mount
from taskbuilder.importing.writing import write_folder
from taskbuilder.visual.robot_picture import take_robot_picture

ROBOTS = "pip/example_robot_data/cmeel.prefix/share/example-robot-data/robots"
AIRO = "pip/airo_models/airo_models"
RTB = "pip/rtb_data/rtbdata/xacro"
SAWYER = "RethinkRobotics+sawyer_robot"
UR = "UniversalRobots+Universal_Robots_ROS2_Description/urdf/ur.urdf.xacro"
ROBOTIQ = "ros-industrial+robotiq/robotiq_2f_85_gripper_visualization/urdf"
KORTEX = "Kinovarobotics+ros_kortex/kortex_description/robots"
KUKA = "ros-industrial+kuka_experimental"
DEX = "dexsuite+dex-urdf/robots"


@dataclass(frozen=True)
class Case:
    """A file, and what an import of it is told."""

    name: str
    file: str
    arguments: dict[str, str] = field(default_factory=dict)
    packages: dict[str, str] = field(default_factory=dict)
    gripper: str = ""
    at: str = ""
    all_arms: bool = False


CASES = (
    Case("SO-100", "TheRobotStudio+SO-ARM100/Simulation/SO100/so100.urdf"),
    Case("SO-101", "TheRobotStudio+SO-ARM100/Simulation/SO101/so101_new_calib.urdf"),
    Case(
        "ViperX 300S",
        "Interbotix+interbotix_ros_manipulators/interbotix_ros_xsarms/"
        "interbotix_xsarm_descriptions/urdf/vx300s.urdf.xacro",
    ),
    Case(
        "xArm7 + gripper",
        "xArm-Developer+xarm_ros/xarm_description/urdf/xarm_device.urdf.xacro",
        {"dof": "7", "add_gripper": "true"},
    ),
    Case(
        "Panda + hand",
        "frankaemika+franka_ros/franka_description/robots/panda/panda.urdf.xacro",
        {"hand": "true"},
    ),
    Case(
        "Kinova Gen3 + 2F-85",
        "Kinovarobotics+ros_kortex/kortex_description/robots/gen3_robotiq_2f_85.xacro",
    ),
    Case(
        "Kinova Gen3 lite",
        "Kinovarobotics+ros_kortex/kortex_description/robots/gen3_lite_gen3_lite_2f.xacro",
    ),
    Case("UR10e", UR, {"ur_type": "ur10e", "name": "ur10e"}),
    Case(
        "UR10e + 2F-85",
        UR,
        {"ur_type": "ur10e", "name": "ur10e"},
        gripper=f"{ROBOTIQ}/robotiq_arg2f_85_model.xacro",
        at="tool0",
    ),
    Case("Robotiq 2F-85", f"{ROBOTIQ}/robotiq_arg2f_85_model.xacro"),
    Case("iiwa14", f"{DEX}/arms/iiwa14/iiwa14.urdf"),
    Case(
        "iiwa14 + 2F-85",
        f"{DEX}/arms/iiwa14/iiwa14.urdf",
        gripper=f"{ROBOTIQ}/robotiq_arg2f_85_model.xacro",
        at="ee_link",
    ),
    Case("iiwa14, GLB", f"{DEX}/arms/iiwa14/iiwa14_glb.urdf"),
    Case("KUKA KR 16-2", f"{KUKA}/kuka_kr16_support/urdf/kr16_2.urdf"),
    Case("KUKA KR 5 arc", f"{KUKA}/kuka_kr5_support/urdf/kr5_arc.xacro"),
    Case(
        "KUKA LBR iiwa",
        f"{KUKA}/kuka_lbr_iiwa_support/urdf/lbr_iiwa_14_r820.urdf",
    ),
    Case(
        "Sawyer + electric gripper",
        f"{SAWYER}/sawyer_description/urdf/sawyer.urdf.xacro",
        {"electric_gripper": "true"},
        {"intera_tools_description": "RethinkRobotics+intera_common/intera_tools_description"},
    ),
    Case("Piper", "agilexrobotics+Piper_ros/src/piper_description/urdf/piper_description.urdf"),
    Case("xArm6 + Robotiq, GLB", "haosulab+ManiSkill-XArm6/xarm6_robotiq.urdf"),
    Case("Panda (example-robot-data)", f"{ROBOTS}/panda_description/urdf/panda.urdf"),
    Case("SO-101 (example-robot-data)", f"{ROBOTS}/so_arm_description/urdf/so101.urdf"),
    Case("UR5 + gripper (example-robot-data)", f"{ROBOTS}/ur_description/urdf/ur5_gripper.urdf"),
    Case("Kinova (example-robot-data)", f"{ROBOTS}/kinova_description/robots/kinova.urdf"),
    Case("xArm7 (example-robot-data)", f"{ROBOTS}/xarm_description/urdf/xarm7.urdf"),
    Case("Z1 (example-robot-data)", f"{ROBOTS}/z1_description/urdf/z1.urdf"),
    Case("Baxter (example-robot-data)", f"{ROBOTS}/baxter_description/urdf/baxter.urdf"),
    Case(
        "Baxter, all arms (example-robot-data)",
        f"{ROBOTS}/baxter_description/urdf/baxter.urdf",
        all_arms=True,
    ),
    Case(
        "Tiago dual, all arms (example-robot-data)",
        f"{ROBOTS}/tiago_description/robots/tiago_dual.urdf",
        all_arms=True,
    ),
    Case(
        "PR2, all arms (example-robot-data)",
        f"{ROBOTS}/pr2_description/urdf/pr2.urdf",
        all_arms=True,
    ),
    Case("Tiago (example-robot-data)", f"{ROBOTS}/tiago_description/robots/tiago.urdf"),
    Case("UR5e (airo-models)", f"{AIRO}/arms/ur5e/ur5e.urdf"),
    Case("UR3e (airo-models)", f"{AIRO}/arms/ur3e/ur3e.urdf"),
    Case("Robotiq 2F-85 (airo-models)", f"{AIRO}/grippers/robotiq_2f_85/urdf/robotiq_2f_85.urdf"),
    Case("Schunk EGK 40 (airo-models)", f"{AIRO}/grippers/schunk_egk40/urdf/schunk_egk40.urdf"),
    Case("Puma 560 (rtb-data)", f"{RTB}/unimation_puma560_description/urdf/puma560_robot.urdf"),
    Case("WSG 50 (pybullet)", "pybullet_data/gripper/wsg50_one_motor_gripper_new.sdf"),
    Case("KUKA iiwa (pybullet)", "pybullet_data/kuka_iiwa/model.sdf"),
)


def before(file: Path) -> str:
    """What checking the untouched file says: ok, or the first code and its message."""
    if file.suffix != ".urdf":
        return f"{file.suffix[1:]} is not read"
    try:
        read_urdf(file, (file.parent,), fixed=True)
    except FileError as error:
        first = next(one for one in error.findings if one.severity == "error")
        return f"{first.code} {first.message.partition(';')[0]}"[:90]
    return "ok"


def imported(case: Case, base: Path, scratch: Path) -> dict[str, Any]:
    """What importing a file comes to."""
    file = located(case.file, base)
    row: dict[str, Any] = {"name": case.name, "file": case.file, "before": "", "result": ""}
    if not file.exists():
        return {**row, "result": "not there"}
    row["before"] = before(file)
    source = ImportSource(
        file,
        {name: base / folder for name, folder in case.packages.items()},
        case.arguments,
        mounts=(Mount(located(case.gripper, base), case.at),) if case.gripper else (),
    )
    began, used = time.perf_counter(), cpu_seconds()
    try:
        results = list(import_arms(source).robots.values()) if case.all_arms else []
        results = results or [import_robot(source)]
        row["seconds"] = round(time.perf_counter() - began, 1)
        row["cpu_seconds"] = round(cpu_seconds() - used, 1)
        for result in results:
            folder = scratch / case.name.replace(" ", "_") / result.name
            write_folder(folder, result.files, overwrite=True)
            urdf = read_urdf(folder / f"{result.name}.urdf", (folder,), fixed=True)
            take_robot_picture(urdf, result.proposal.open if result.proposal else {}, trusted=True)
    except (TaskbuilderError, AssetError) as error:
        findings = getattr(error, "findings", ())
        said = f"{findings[0].code} {findings[0].message}" if findings else str(error)
        return {
            **row,
            "result": f"refused: {said.partition(';')[0]}"[:160],
            "findings": len(findings),
        }
    result = results[0]
    proposal = result.proposal
    row |= {
        "arms": len(results),
        "result": "ok",
        "arm": len(proposal.arm) if proposal else 0,
        "fingers": len(proposal.fingers) if proposal else 0,
        "stroke_mm": round(proposal.stroke * 1000) if proposal and proposal.gripper else None,
        "changes": len(result.changes.rows),
        "left_out": len(result.changes.left_out),
        "questions": list(proposal.remarks) if proposal else ["no arm"],
    }
    return row


def cpu_seconds() -> float:
    """Seconds of the processor of this process and of the children that it has waited for."""
    mine, children = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, _CHILDREN))
    return mine.ru_utime + mine.ru_stime + children.ru_utime + children.ru_stime


_CHILDREN = resource.RUSAGE_CHILDREN


def located(reference: str, base: Path) -> Path:
    data = pybullet_data_folder()
    if reference.startswith("pybullet_data/") and data is not None:
        return data / reference.removeprefix("pybullet_data/")
    return base / reference


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument(
        "--minutes", type=float, default=math.inf, help="of the processor, after which it stops"
    )
    parser.add_argument(
        "--missing", action="store_true", help="only those that the results do not have yet"
    )
    parser.add_argument("--only", default="", help="parts of names, with commas")
    parser.add_argument("--scratch", type=Path, default=Path("/tmp/imports"))
    parser.add_argument("--out", type=Path, default=Path("benchmarks/results/imports.json"))
    given = parser.parse_args()
    kept = json.loads(given.out.read_text())["files"] if given.out.exists() else []
    rows = {row["name"]: row for row in kept}
    for case in CASES:
        if given.only and not any(word in case.name for word in given.only.split(",")):
            continue
        if given.missing and case.name in rows:
            continue
        if cpu_seconds() / 60.0 > given.minutes:
            print(f"stopped after {given.minutes:g} minutes of the processor; go on with --missing")
            break
        try:
            rows[case.name] = imported(case, given.folder.resolve(), given.scratch)
        except Exception as error:  # a defect is a result, too
            said = f"defect: {type(error).__name__}: {error}"[:160]
            rows[case.name] = {"name": case.name, "file": case.file, "before": "", "result": said}
        print(rows[case.name], flush=True)
        ordered = [rows[one.name] for one in CASES if one.name in rows]
        good = sum(row["result"] == "ok" for row in ordered)
        given.out.write_text(
            json.dumps({"imported": good, "of": len(ordered), "files": ordered}, indent=1) + "\n"
        )


if __name__ == "__main__":
    main()
