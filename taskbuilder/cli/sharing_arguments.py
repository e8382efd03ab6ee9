"""Arguments of the commands `push`, `pull` and `leaderboard`."""

from __future__ import annotations

from pathlib import Path

from taskbuilder.cli.learning_arguments import CommandAdder
from taskbuilder.cli.shared_options import add_count, add_jobs, add_json, add_ray


def add_push(adder: CommandAdder) -> None:
    """`taskbuilder push`."""
    parser = adder.command(
        "share a task, a data set, a policy or a certificate in a directory or a repository",
        "mine.yaml git@host:lab/robots.git --tag v1",
    )
    parser.add_argument(
        "what",
        metavar="WHAT",
        help="name of a task, or path of a task file, of the folder of a data set or of a training "
        "run, of a policy's file, or of a certificate; or a policy such as zoo:handover/demos",
    )
    parser.add_argument(
        "destination",
        metavar="DESTINATION",
        help="a directory; a git repository: an address, or the path of a bare repository; or a "
        "repository of the Hugging Face Hub, such as hf://lab/robots or hf://datasets/lab/robots",
    )
    parser.add_argument(
        "--name", metavar="NAME", help="name to share it by (default: its own name)"
    )
    parser.add_argument("--tag", metavar="TAG", help="in a repository: tag of the commit")
    parser.add_argument(
        "--replace", action="store_true", help="replace another one of the same name"
    )
    add_json(parser)


def add_pull(adder: CommandAdder) -> None:
    """`taskbuilder pull`."""
    parser = adder.command(
        "get a task, a data set, a policy or a certificate that was pushed, and check its files",
        "mine@v1 git@host:lab/robots.git",
    )
    parser.add_argument(
        "name",
        metavar="NAME[@REVISION]",
        help="its name, such as mine or tasks/mine; in a repository also a branch, a tag or a "
        "commit",
    )
    parser.add_argument(
        "source", metavar="SOURCE", help="the directory or repository, as push has it"
    )
    parser.add_argument(
        "--out",
        type=Path,
        metavar="DIR",
        help="new folder to write to (default: of its name, in the current folder)",
    )
    parser.add_argument(
        "--trust",
        nargs="?",
        const=True,
        default=False,
        metavar="SHA256",
        help="accept a task, or the one of this SHA-256; a task is a program, so read it first",
    )
    add_json(parser)


def add_leaderboard(adder: CommandAdder) -> None:
    """`taskbuilder leaderboard`."""
    parser = adder.command(
        "make a leaderboard of a folder of certificates, and play a sample of each again",
        "certificates --replay 10 --out board",
    )
    parser.add_argument(
        "folder", type=Path, metavar="FOLDER", help="folder of the certificates and policies"
    )
    add_count(
        parser,
        "--replay",
        (0, 100_000),
        "episodes of each certificate to play again, chosen at random",
        default=5,
    )
    parser.add_argument(
        "--also",
        action="append",
        type=Path,
        default=[],
        metavar="FILE",
        help="leaderboard.json of another machine, whose verifications are believed (may be "
        "repeated)",
    )
    parser.add_argument(
        "--out",
        type=Path,
        default=Path("leaderboard"),
        metavar="DIR",
        help="folder to write to (default leaderboard); verifications that are there are kept",
    )
    add_jobs(parser)
    add_ray(parser, "the episodes")
    add_json(parser)
