"""Arguments of the commands `train`, `evaluate` and `plot`."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Protocol, get_args

from taskbuilder import extensions
from taskbuilder.cli.argument_types import (
    Extend,
    PartName,
    any_variation,
    count_or_folder,
    listed,
    number,
    share,
    whole,
)
from taskbuilder.cli.env_options import add_env_options
from taskbuilder.cli.shared_options import (
    SEEDS,
    add_count,
    add_jobs,
    add_json,
    add_picture,
    add_ray,
    add_trust,
)
from taskbuilder.env.options import option_infos
from taskbuilder.learn.algorithms import ALGORITHMS
from taskbuilder.schema.choices import LadderChoice
from taskbuilder.schema.disturbances import axes_text


class CommandAdder(Protocol):
    """Adds a command to the parser."""

    def command(self, summary: str, example: str) -> argparse.ArgumentParser:
        """The parser of the command."""


def add_train(adder: CommandAdder) -> None:
    """`taskbuilder train`."""
    parser = adder.command(
        "train a policy for each robot of a task",
        "handover --steps 300000 --seed 1 --out runs/handover-1",
    )
    parser.add_argument(
        "task",
        nargs="?",
        metavar="TASK",
        help="name of the task, or path of its YAML file (default: the task of the data set "
        "--data)",
    )
    parser.add_argument(
        "--resume", type=Path, metavar="RUN", help="continue the run in this folder"
    )
    add_trust(parser, "--resume: ")
    parser.add_argument(
        "--out", type=Path, metavar="RUN", help="folder of the run (default runs/TASK-TRACK-SEED)"
    )
    *most, last = ALGORITHMS
    parser.add_argument(
        "--algorithm",
        type=PartName(ALGORITHMS, extensions.ALGORITHMS),
        metavar="A",
        help=f"{', '.join(most)} or {last} (default maddpg)",
    )
    parser.add_argument(
        "--preset",
        metavar="P",
        help="named set of settings, such as paper; it may change the defaults of other options",
    )
    parser.add_argument(
        "--reward",
        metavar="R",
        help="training reward: team, local, sparse, shaped or ratchet (default ratchet)",
    )
    many = whole(1, 1_000_000_000)
    parser.add_argument(
        "--steps",
        type=many,
        metavar="N",
        help="number of control steps (default 300000); for bc, number of updates (default 5000, "
        "or 10000 with --cameras)",
    )
    parser.add_argument(
        "--seed",
        "--seeds",
        action=Extend,
        nargs="+",
        type=whole(0, 2**31 - 1),
        metavar="N",
        help="random seed (default 0); with several seeds, one run for each seed, in the folder "
        "RUN-SEED",
    )
    add_count(parser, "--jobs", (1, 1024), "number of runs to train at once (default 1)")
    add_ray(parser, "the runs of several seeds")
    add_count(parser, "--envs", (1, 1024), "number of parallel environments (default 4)")
    add_count(
        parser,
        "--workers",
        (0, 1024),
        "number of worker processes that run the environments; with 0, the training process "
        "runs them (default 0)",
    )
    parser.add_argument(
        "--demos",
        type=count_or_folder,
        metavar="N|DIR",
        help="also learn from N expert episodes, or from a data set; bc learns from a data set "
        "alone",
    )
    parser.add_argument(
        "--starts",
        type=share,
        metavar="SHARE",
        help="fraction of training episodes that begin in a state from an episode of the expert",
    )
    parser.add_argument(
        "--no-progress-timeout-s",
        type=number(0.001, 1_000_000.0),
        metavar="SECONDS",
        help="end a training episode after this time without progress (default, with the reward "
        "ratchet: 1.5 times the longest time that the expert needs in 20 episodes, at least 1.5)",
    )
    parser.add_argument(
        "--ladder",
        choices=get_args(LadderChoice),
        help="where the progress comes from that training sees, from 0 to 1; task: the progress in "
        "the description; expert: the stages of the expert (default task; expert where a "
        "description has no progress)",
    )
    parser.add_argument(
        "--init",
        metavar="POLICY",
        help="policy to start from: zoo:TASK/TRACK, the folder of a run, or a policy file",
    )
    parser.add_argument(
        "--data", metavar="DIR", help="data set that bc learns from, made by taskbuilder collect"
    )
    parser.add_argument(
        "--cameras",
        type=listed,
        metavar="C,C",
        help="for bc: cameras of the data set; each policy then observes their pictures, the "
        "values of its own robot, and the time left in the episode",
    )
    parser.add_argument(
        "--device", metavar="D", help="device on which the networks run: cpu or cuda (default cpu)"
    )
    add_env_options(
        parser,
        without=("reward",),
        unless_given={
            "frame": "base",
            "rotation": "matrix",
            "distances": "metres; log with maddpg's presets demos and scratch",
        },
    )
    parser.add_argument(
        "--evaluate-every",
        type=many,
        metavar="N",
        help="control steps between evaluations (default 10000); for bc, updates (default 1000, or "
        "2000 with --cameras)",
    )
    parser.add_argument(
        "--evaluate-episodes", type=many, metavar="N", help="episodes per evaluation (default 20)"
    )
    add_count(
        parser,
        "--film-every",
        (0, 1_000_000),
        "film one episode in every Nth evaluation; with 0, film none (default 10)",
    )
    parser.add_argument(
        "--checkpoint-every",
        type=many,
        metavar="N",
        help="control steps between checkpoints (default 10000); for bc, updates (default 1000, or "
        "2000 with --cameras)",
    )
    parser.add_argument(
        "--stop-at",
        type=share,
        metavar="SHARE",
        help="stop when, in two evaluations in a row, success holds at the last control step in "
        "this share of the episodes",
    )
    parser.add_argument(
        "--set",
        action=Extend,
        nargs="+",
        metavar="K=V",
        help="settings of the algorithm, such as noise=0.2",
    )


def add_evaluate(adder: CommandAdder) -> None:
    """`taskbuilder evaluate`."""
    parser = adder.command(
        "measure the success rate of a policy in episodes that were not used in training",
        "zoo:handover/demos --episodes 300 --certificate handover.json",
    )
    parser.add_argument(
        "policy",
        nargs="?",
        metavar="POLICY",
        help="zoo:TASK/TRACK, the folder of a run, or a policy file; expert:TASK, "
        "noisy:0.3:TASK, random:TASK or hold:TASK; or a policy server, ws://HOST:PORT/TASK?cameras=C,C&size=WxH&steps=N&renderer=R",
    )
    add_count(parser, "--episodes", (1, 100_000), "episodes to play", default=300)
    add_count(
        parser,
        "--seed",
        SEEDS,
        "seed of the first episode (default 2000000, never used in training); the next "
        "episodes have the next seeds",
        default=2_000_000,
    )
    parser.add_argument(
        "--variation",
        type=any_variation,
        metavar="K",
        help="number of the variation; or random, which draws a variation for each episode; or "
        "all, which plays all episodes in each variation (default: as in training)",
    )
    add_env_options(
        parser,
        without=("variation", "reward", "disturbances"),
        also={"position_noise": "--noise"},
        unless_given={
            name: "as in training" for name, info in option_infos().items() if info.decides_policy
        },
    )
    parser.add_argument(
        "--disturb",
        action="append",
        metavar="AXIS[=N]",
        help="also play all episodes under this disturbance, and compare; may be repeated, one "
        "disturbance is played after the other; all stands for all of them. An axis with its level "
        f"N, or at its level by default: {axes_text()}".replace("%", "%%"),
    )
    add_count(
        parser,
        "--controls",
        (0, 100_000),
        "number of seeds that the baselines also play, for comparison; the baselines are the "
        "expert, random actions, holding still, and stalls (default 20; for a certificate, all "
        "seeds; with --disturb, none)",
    )
    add_jobs(parser)
    add_ray(parser, "episodes")
    parser.add_argument(
        "--certificate",
        type=Path,
        metavar="FILE",
        help="write a certificate: the result, with everything needed to repeat the evaluation",
    )
    parser.add_argument(
        "--verify",
        type=Path,
        metavar="FILE",
        help="repeat the evaluation of a certificate, compare the results bit for bit, and print "
        "the differences",
    )
    parser.add_argument(
        "--out",
        type=Path,
        metavar="DIR",
        help="folder for the result and films (default evaluations)",
    )
    parser.add_argument(
        "--video",
        action="store_true",
        help="film the best, a median and a failed episode, as MP4 and GIF",
    )
    add_trust(parser, "")
    add_picture(parser, cameras="the first camera of the scene", of="a film")
    add_env_options(parser, ("renderer",))
    add_json(parser)


def add_plot(adder: CommandAdder) -> None:
    """`taskbuilder plot`."""
    parser = adder.command(
        "draw learning curves of training runs; runs that differ only in their seed share a curve",
        "runs/handover-scratch-0 runs/handover-scratch-1 --out curves.png",
    )
    parser.add_argument(
        "runs", nargs="+", metavar="RUN", help="folders of training runs of the same task"
    )
    parser.add_argument(
        "--beside",
        action=Extend,
        nargs="+",
        type=Path,
        default=[],
        metavar="CSV",
        help="also draw learning curves of other software, from files with the columns step, "
        "success_rate or team_return or both, and seed if there are several seeds",
    )
    parser.add_argument(
        "--out", type=Path, required=True, metavar="FILE", help="file of the picture, .png or .svg"
    )
    parser.add_argument(
        "--title", metavar="T", help="title of the picture (default: name of the task)"
    )
