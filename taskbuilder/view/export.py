"""An episode as one HTML file, which plays in three dimensions and needs no server."""

from __future__ import annotations

from pathlib import Path

from taskbuilder.files import write_whole
from taskbuilder.geometry import Vec3
from taskbuilder.view.recording import Recording
from taskbuilder.view.scene import BrowserScene, look_from
from taskbuilder.view.server import PageServer
from taskbuilder.world.world import World

ABOVE_M = 0.5
"""What is said of the episode stands so far above the highest robot's tool."""

LAST_S = 1.5
"""The last state is shown for so long before the episode begins again, in seconds."""


def export(world: World, recording: Recording, file: Path) -> None:
    """Write an episode as an HTML file.

    Args:
        world: The world of the episode's variation, in any state.
        recording: The episode.
        file: The file to write.

    Raises:
        UsageError: Viser is not installed.
        OSError: The file cannot be written.
    """
    write_whole(file, as_html(world, recording).encode())


def as_html(world: World, recording: Recording) -> str:
    """An episode as a page of HTML.

    Args:
        world: The world of the episode's variation, in any state.
        recording: The episode.

    Raises:
        UsageError: Viser is not installed.
    """
    server = PageServer(0)
    try:
        scene = BrowserScene(server.viser, lambda _: None)
        scene.show(world)
        look_from(server.viser, world)
        scene.place(recording.moments[0].poses)
        label = server.viser.scene.add_label("/episode", "", position=_top(world))
        serializer = server.viser.get_scene_serializer()
        for step, moment in enumerate(recording.moments):
            scene.place(moment.poses)
            label.text = _words(recording, step)
            serializer.insert_sleep(1.0 / recording.control_hz)
        serializer.insert_sleep(LAST_S)
        html: str = serializer.as_html()
        return html
    finally:
        server.close()


def _top(world: World) -> Vec3:
    """A point above the middle of the robots' tools, in metres."""
    tools = [world.position(f"{name}.tcp") for name in world.robots]
    x, y, z = zip(*tools, strict=True)
    return sum(x) / len(x), sum(y) / len(y), max(z) + ABOVE_M


def _words(recording: Recording, step: int) -> str:
    """The stage that was reached, the time, and at the end how it ended."""
    rollout = recording.rollout
    stage = rollout.stages[rollout.stage[step] - 1] if rollout.stage[step] else "begun"
    text = f"{rollout.task} · {rollout.seconds(step):.1f} s · {stage}"
    return f"{text} · {recording.verdict()}" if step == rollout.steps else text
