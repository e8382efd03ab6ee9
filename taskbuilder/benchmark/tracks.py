"""The tracks of the benchmark: what each allows for learning, and how policies are evaluated.

A track is data, and this file is the only place that says what a track is. A change that makes
results incomparable is a new version, whose claims are made on seeds that nobody has seen.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Annotated

from pydantic import Field

from taskbuilder.env.options import EnvOptions
from taskbuilder.errors import UnknownNameError
from taskbuilder.schema.values import Model, Name, Text
from taskbuilder.wording import suggestion

CLAIMS_FROM = 3_000_000
"""First seed of version 1, whose demonstrations had no noise; every version has its own."""

CLAIMS_APART = 100_000
"""Seeds between the evaluations of one version and those of the next."""

Count = Annotated[int, Field(ge=1, le=1_000_000_000)]
Share = Annotated[float, Field(gt=0.0, le=1.0)]

DEVELOPMENT = ("reach", "press_button", "insert_peg", "double_door", "handover")
"""Tasks on which methods may be tuned; results on others show what was not tuned."""


class DemonstrationSet(Model):
    """Episodes of the task's expert to learn from.

    The expert is disturbed, so that policies see how to come back to its way. How much disturbance
    an expert bears differs from task to task, so the strongest of several levels is taken under
    which it mostly succeeds, or none.

    Attributes:
        episodes: Number of episodes of each task; the train variations of the suite take turns.
        first_seed: Seed of the first attempt.
        noise: Standard deviations of the noise on the actions, the strongest first.
        noise_share: Share of the control steps that have noise.
        trials: Episodes of each level, with the seeds from the first on.
        trials_needed: Of these, how many have to succeed.
    """

    episodes: Count = 300
    first_seed: int = Field(default=500_000, ge=0)
    noise: tuple[Share, ...] = (0.1, 0.05, 0.02)
    noise_share: Share = 0.25
    trials: Count = 20
    trials_needed: Count = 16

    @property
    def experts(self) -> tuple[str, ...]:
        """The experts with noise, the strongest first, as texts of `parse_policy`."""
        return tuple(f"noisy:{noise:g}@{self.noise_share:g}" for noise in self.noise)


class Training(Model):
    """The budget of a training run.

    Attributes:
        steps: Updates, where policies learn from demonstrations; otherwise control steps.
        evaluate_every: Steps between evaluations, by which the policy of a run is chosen.
        evaluate_episodes: Episodes of each of these.
        cpu_minutes: Limit of the CPU time, these evaluations included. It is not enforced, or
            results would depend on the machine; what took longer is marked.
    """

    steps: Count
    evaluate_every: Count
    evaluate_episodes: Count
    cpu_minutes: float = Field(gt=0.0)


class Track(Model):
    """What a method may use, and how its policies are evaluated.

    Attributes:
        name: Name of the track.
        version: Version; results of different versions are not comparable.
        summary: One sentence about the track.
        cameras: Number of cameras that policies observe, the first of the scene; with 0, policies
            observe the state of the whole scene.
        camera_size: Width and height of their pictures.
        demonstrations: Episodes to learn from; None where policies learn by acting.
        training: Budget of each training run.
        episodes: Episodes of the evaluation in each test variation of the suite.
        baseline_episodes: First of these that the expert and random actions play, too.
        safe_force: Force between two robots, in newtons, that safe success never exceeds.
        development: Tasks on which methods may be tuned.
        smoke: Whether it is a short version, to see that everything works.
    """

    name: Name
    version: int = Field(default=2, ge=1, le=10_000)
    summary: Text
    cameras: int = Field(default=0, ge=0, le=16)
    camera_size: tuple[int, int] = (84, 84)
    demonstrations: DemonstrationSet | None = None
    training: Training
    episodes: Count = 300
    baseline_episodes: Count = 20
    safe_force: float = Field(default=100.0, gt=0.0)
    development: tuple[str, ...] = DEVELOPMENT
    smoke: bool = False

    @property
    def first_seed(self) -> int:
        """Seed of the first episode of evaluations; every version has seeds of its own."""
        return CLAIMS_FROM + CLAIMS_APART * (self.version - 1)

    @property
    def observes(self) -> str:
        """What policies observe, in words."""
        if not self.cameras:
            return "the state of the whole scene"
        width, height = self.camera_size
        several = f"the first {self.cameras} cameras" if self.cameras > 1 else "the first camera"
        return (
            f"pictures of {several} of the scene, {width}x{height} pixels, each robot's own values "
            "and the time left"
        )

    @property
    def is_official(self) -> bool:
        """Whether it is one of the tracks of the library, neither shortened nor changed."""
        return TRACKS.get(self.name) == self

    @property
    def label(self) -> str:
        """The track in a few words; results of one that is not official say so."""
        if self.is_official:
            return f"{self.name}, version {self.version}"
        what = "smoke version" if self.smoke else "changed"
        return f"{self.name}, version {self.version}, {what}: not comparable"

    @property
    def options(self) -> EnvOptions:
        """The options of the environments in which a method learns, pictures apart."""
        return {"observe": "scene", "frame": "base", "rotation": "matrix", "distances": "log"}


TRACKS: Mapping[str, Track] = MappingProxyType(
    {
        track.name: track
        for track in (
            Track(
                name="imitation",
                summary="Policies learn from states in demonstrations, without acting.",
                demonstrations=DemonstrationSet(),
                training=Training(
                    steps=15_000, evaluate_every=3_000, evaluate_episodes=50, cpu_minutes=5.0
                ),
            ),
            Track(
                name="vision",
                summary="Policies learn from pictures in demonstrations, without acting.",
                cameras=2,
                demonstrations=DemonstrationSet(episodes=200),
                training=Training(
                    steps=15_000, evaluate_every=3_000, evaluate_episodes=20, cpu_minutes=40.0
                ),
            ),
            Track(
                name="reinforcement",
                summary="Policies learn from states by acting, without demonstrations.",
                training=Training(
                    steps=300_000, evaluate_every=10_000, evaluate_episodes=50, cpu_minutes=120.0
                ),
            ),
        )
    }
)
"""The tracks by name."""

_SMOKE: Mapping[str, Training] = {
    "imitation": Training(steps=1_000, evaluate_every=500, evaluate_episodes=5, cpu_minutes=1.0),
    "vision": Training(steps=60, evaluate_every=60, evaluate_episodes=2, cpu_minutes=1.0),
    "reinforcement": Training(
        steps=2_000, evaluate_every=1_000, evaluate_episodes=5, cpu_minutes=2.0
    ),
}


def find_track(name: str, *, smoke: bool = False) -> Track:
    """Look up a track by its name.

    Args:
        name: Name of the track.
        smoke: Whether to take its short version, which a small suite finishes within ten minutes on
            two cores.

    Raises:
        UnknownNameError: There is no such track.
    """
    if name not in TRACKS:
        raise UnknownNameError(f'no track "{name}"; {suggestion(name, TRACKS, what="there are")}')
    track = TRACKS[name]
    return smoke_version(track) if smoke else track


def smoke_version(track: Track) -> Track:
    """The short version of a track of the library."""
    pictures = bool(track.cameras)
    shown = track.demonstrations
    few = shown and shown.model_copy(
        update={"episodes": 4 if pictures else 30, "trials": 3, "trials_needed": 2}
    )
    return track.model_copy(
        update={
            "smoke": True,
            "demonstrations": few,
            "training": _SMOKE[track.name],
            "episodes": 3 if pictures else 20,
            "baseline_episodes": 3,
        }
    )
