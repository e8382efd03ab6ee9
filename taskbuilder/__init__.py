"""Author, prove and render multi-robot manipulation tasks on PyBullet.

What is here is imported when it is first used, so that ``import taskbuilder`` costs nothing.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from taskbuilder._lazy import exported
from taskbuilder._version import __version__

if TYPE_CHECKING:
    from taskbuilder.benchmark import benchmark
    from taskbuilder.data.collection import collect, export
    from taskbuilder.data.dataset import Dataset, RecordedEpisode, load_dataset
    from taskbuilder.data.environment import make_from
    from taskbuilder.env.joint import JointEnv
    from taskbuilder.env.numeric_infos import NumericInfos
    from taskbuilder.env.parallel import TaskEnv, parallel_env
    from taskbuilder.env.vector import TaskVectorEnv, make_vec
    from taskbuilder.errors import FileError, TaskbuilderError, UnknownNameError, UsageError
    from taskbuilder.evaluation.assessment import evaluate
    from taskbuilder.evaluation.filming import film
    from taskbuilder.evaluation.summary import EvaluationSummary
    from taskbuilder.evaluation.verify import Verification, verify
    from taskbuilder.expert.script.player import Expert
    from taskbuilder.learn.runs import TrainedRun, train
    from taskbuilder.multiplying.multiply import multiply
    from taskbuilder.policies.grammar import parse_policy
    from taskbuilder.policies.trained import TrainedPolicy
    from taskbuilder.policies.zoo import load_policy
    from taskbuilder.rollout.play import Policy, play, replay
    from taskbuilder.rollout.record import Rollout
    from taskbuilder.schema.catalogue import Catalogue
    from taskbuilder.schema.suites import Suite
    from taskbuilder.sharing.pulling import Pulled, pull
    from taskbuilder.sharing.pushing import Pushed, push
    from taskbuilder.task import Task, load_task
    from taskbuilder.validate import validate
    from taskbuilder.validate.environments import check_env
    from taskbuilder.validate.report import TaskReport
    from taskbuilder.validate.runner import validate_task
    from taskbuilder.view.notebook import EpisodeView, show
    from taskbuilder.visual.rendering import render
    from taskbuilder.world.building import build_world
    from taskbuilder.world.world import World

__all__ = [
    "Catalogue",
    "Dataset",
    "EpisodeView",
    "EvaluationSummary",
    "Expert",
    "FileError",
    "JointEnv",
    "NumericInfos",
    "Policy",
    "Pulled",
    "Pushed",
    "RecordedEpisode",
    "Rollout",
    "Suite",
    "Task",
    "TaskEnv",
    "TaskReport",
    "TaskVectorEnv",
    "TaskbuilderError",
    "TrainedPolicy",
    "TrainedRun",
    "UnknownNameError",
    "UsageError",
    "Verification",
    "World",
    "__version__",
    "benchmark",
    "build_world",
    "catalogue",
    "check_env",
    "collect",
    "evaluate",
    "export",
    "film",
    "load_dataset",
    "load_policy",
    "load_suite",
    "load_task",
    "make_from",
    "make_vec",
    "multiply",
    "parallel_env",
    "parse_policy",
    "play",
    "pull",
    "push",
    "render",
    "replay",
    "show",
    "train",
    "validate",
    "validate_task",
    "verify",
]

_HOMES = {
    "Catalogue": "taskbuilder.schema.catalogue",
    "Dataset": "taskbuilder.data.dataset",
    "EpisodeView": "taskbuilder.view.notebook",
    "EvaluationSummary": "taskbuilder.evaluation.summary",
    "Expert": "taskbuilder.expert.script.player",
    "FileError": "taskbuilder.errors",
    "JointEnv": "taskbuilder.env.joint",
    "NumericInfos": "taskbuilder.env.numeric_infos",
    "Policy": "taskbuilder.rollout.play",
    "Pulled": "taskbuilder.sharing.pulling",
    "Pushed": "taskbuilder.sharing.pushing",
    "RecordedEpisode": "taskbuilder.data.dataset",
    "Rollout": "taskbuilder.rollout.record",
    "Suite": "taskbuilder.schema.suites",
    "Task": "taskbuilder.task",
    "TaskEnv": "taskbuilder.env.parallel",
    "TaskReport": "taskbuilder.validate.report",
    "TaskVectorEnv": "taskbuilder.env.vector",
    "TaskbuilderError": "taskbuilder.errors",
    "TrainedPolicy": "taskbuilder.policies.trained",
    "TrainedRun": "taskbuilder.learn.runs",
    "UnknownNameError": "taskbuilder.errors",
    "UsageError": "taskbuilder.errors",
    "Verification": "taskbuilder.evaluation.verify",
    "World": "taskbuilder.world.world",
    "benchmark": "taskbuilder.benchmark",
    "build_world": "taskbuilder.world.building",
    "check_env": "taskbuilder.validate.environments",
    "collect": "taskbuilder.data.collection",
    "evaluate": "taskbuilder.evaluation.assessment",
    "export": "taskbuilder.data.collection",
    "film": "taskbuilder.evaluation.filming",
    "load_dataset": "taskbuilder.data.dataset",
    "load_policy": "taskbuilder.policies.zoo",
    "load_task": "taskbuilder.task",
    "make_from": "taskbuilder.data.environment",
    "make_vec": "taskbuilder.env.vector",
    "multiply": "taskbuilder.multiplying.multiply",
    "parallel_env": "taskbuilder.env.parallel",
    "parse_policy": "taskbuilder.policies.grammar",
    "play": "taskbuilder.rollout.play",
    "pull": "taskbuilder.sharing.pulling",
    "push": "taskbuilder.sharing.pushing",
    "render": "taskbuilder.visual.rendering",
    "replay": "taskbuilder.rollout.play",
    "show": "taskbuilder.view.notebook",
    "train": "taskbuilder.learn.runs",
    "validate": "taskbuilder.validate",
    "validate_task": "taskbuilder.validate.runner",
    "verify": "taskbuilder.evaluation.verify",
}


if not TYPE_CHECKING:  # to a type checker, a name that is not listed above is a mistake
    __getattr__, __dir__ = exported(__name__, _HOMES)


def catalogue(*folders: str) -> Catalogue:
    """Make a catalogue: all tasks and robots that can be used by name.

    Args:
        folders: Folders to search in addition to installed packages and TASKBUILDER_PATH.

    Raises:
        UnknownNameError: A folder does not exist.
    """
    from taskbuilder.schema.catalogue import Catalogue

    return Catalogue.discover(folders)


def load_suite(name: str, *, catalogue: Catalogue | None = None) -> Suite:
    """Load a suite: a group of tasks, with the variations and seeds to train and to test on.

    Args:
        name: Name of the suite: ``seed``, ``single``, ``pairs``, ``trios``, ``quads``, or a suite
            that a ``suites.yaml`` in a folder of the catalogue defines.
        catalogue: Catalogue in which to look up the suite; by default the catalogue of this
            installation.

    Raises:
        UnknownNameError: There is no such suite.
        FileError: A ``suites.yaml`` has errors.
    """
    from taskbuilder.schema import suites
    from taskbuilder.schema.catalogue import Catalogue

    return suites.find_suite(name, catalogue or Catalogue.discover())
