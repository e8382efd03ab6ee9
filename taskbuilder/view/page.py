"""The page: what is shown, what can be switched and played, and the loop that updates it.

All physics run in the thread of `LivePage.run`. What a browser sends only puts a request into a
queue.
"""

from __future__ import annotations

import queue
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Any

import numpy as np

from taskbuilder.errors import TaskbuilderError
from taskbuilder.view.recording import RecordedState, Recording
from taskbuilder.view.scene import BrowserScene, camera_pictures, look_from, switches
from taskbuilder.view.server import PageServer
from taskbuilder.view.stage import Choice, Stage
from taskbuilder.view.words import conditions, findings, heading, outcome, plain, pose_yaml, stages
from taskbuilder.world.building import build_world
from taskbuilder.world.visible import LinkPoses
from taskbuilder.world.world import World

PICTURES_HZ = 30
SPEEDS = ("0.25", "0.5", "1", "2", "4")
POLL_S = 0.1
"""Between looks at the files."""

MOST_REQUESTS = 100
"""Requests that wait; those of a browser that floods the page are dropped."""

Request = Callable[[], None]


class LivePage:
    """A task on a page that follows its files.

    Args:
        stage: The task.
        server: The server of the page.
        choice: What is played first.
    """

    def __init__(self, stage: Stage, server: PageServer, choice: Choice) -> None:
        self._stage, self._server, self._choice = stage, server, choice
        self._requests: queue.Queue[Request] = queue.Queue(MOST_REQUESTS)
        self._world: World | None = None
        self._recording: Recording | None = None
        self._step = 0.0
        self._playing = False
        self._scene = BrowserScene(server.viser, lambda name: self._ask(lambda: self._pick(name)))
        self._make_controls()
        self._show_task(first=True)

    # --- requests

    def _ask(self, request: Request) -> None:
        with suppress(queue.Full):
            self._requests.put_nowait(request)

    def run(self, until: Callable[[], bool] = lambda: False) -> None:
        """Answer requests, follow the files and play, until it is interrupted.

        Args:
            until: Whether to stop.
        """
        last = looked = time.monotonic()
        while not until():
            now = time.monotonic()
            if now - looked > POLL_S:
                looked = now
                if self._stage.changed():
                    self._reload()
            self._advance(now - last)
            last = now
            with suppress(queue.Empty):
                self._requests.get(timeout=1.0 / PICTURES_HZ)()

    def close(self) -> None:
        """Free the world that is shown."""
        if self._world is not None:
            self._world.close()
            self._world = None

    # --- controls

    def _make_controls(self) -> None:
        gui = self._server.viser.gui
        self._heading = gui.add_markdown("")
        tabs = gui.add_tab_group()
        with tabs.add_tab("Episode"):
            players = dict.fromkeys((*self._stage.players, self._choice.player))
            self._player = gui.add_dropdown(
                "Player", tuple(players), initial_value=self._choice.player
            )
            self._seed = gui.add_number("Seed", initial_value=self._choice.seed, min=0, step=1)
            self._variation = gui.add_number(
                "Variation", initial_value=self._choice.variation, min=0, step=1
            )
            play = gui.add_button("Play an episode")
            self._slider = gui.add_slider("Step", min=0, max=1, step=1, initial_value=0)
            moves = gui.add_button_group("", tuple(MOVES))
            self._speed = gui.add_dropdown("Speed", SPEEDS, initial_value="1")
            self._outcome = gui.add_markdown("")
            self._stages = gui.add_markdown("")
            self._lamps = gui.add_markdown("")
            self._charts: list[Any] = []
            self._chart_folder = gui.add_folder("Rewards and forces")
        with tabs.add_tab("Scene"):
            self._boxes = {
                word: gui.add_checkbox(word.capitalize(), initial_value=on)
                for word, on in switches().items()
            }
            self._pictures: list[Any] = []
            self._picture_folder = gui.add_folder("What cameras see", visible=False)
            self._picked = gui.add_markdown("Click a part of the scene to see its name and pose.")
        with tabs.add_tab("Findings"):
            self._findings = gui.add_markdown("")
        play.on_click(lambda _: self._ask(self._play))
        moves.on_click(lambda _: self._ask(lambda: MOVES[moves.value](self)))
        self._slider.on_update(self._scrubbed)
        for word, box in self._boxes.items():
            box.on_update(lambda _, word=word: self._ask(lambda: self._switch(word)))

    def _scrubbed(self, event: Any) -> None:
        """Go to a step; only if a person moved the slider, not the page itself."""
        if event.client is not None:
            self._ask(lambda: self._go_to(self._slider.value, pause=True))

    # --- the task

    def _reload(self) -> None:
        read = self._stage.load()
        self._say_findings()
        if read:
            self._show_task()

    def _show_task(self, *, first: bool = False) -> None:
        task = self._stage.task
        self._say_findings()
        if task is None:
            return
        self._heading.content = heading(task)
        self._recording, self._playing = None, False
        self.close()
        variation = min(self._choice_now().variation, len(task.file.scenes) - 1)
        try:
            self._world = build_world(task.file, variation=variation)
            self._world.reset(self._choice_now().seed)
        except TaskbuilderError as error:
            self._say(error)
            return
        if first:
            look_from(self._server.viser, self._world)
        self._scene.show(self._world)
        self._scene.place(LinkPoses(self._world).now())
        for word, box in self._boxes.items():
            if box.value:
                self._switch(word)
        self._outcome.content = "Press *Play an episode*."
        self._stages.content = stages(tuple(task.description.stages), 0)
        self._lamps.content = ""

    def _say_findings(self) -> None:
        self._findings.content = findings(self._stage.findings)
        count = len(self._stage.findings)
        if count:
            words = "1 finding" if count == 1 else f"{count} findings"
            self._outcome.content = f"✗ {words}: see the tab *Findings*."

    def _say(self, error: TaskbuilderError) -> None:
        found = self._stage.explain(error)
        self._findings.content = findings(found) if found else f"✗ {plain(str(error))}"
        self._outcome.content = f"✗ {plain(str(error))}"

    def _pick(self, name: str) -> None:
        if self._world is None:
            return
        try:
            pose = self._world.pose(name)
        except (TaskbuilderError, KeyError):
            self._picked.content = f"**{plain(name)}**"
            return
        self._picked.content = f"**{plain(name)}**\n\n{pose_yaml(name, pose)}"

    def _switch(self, word: str) -> None:
        on = self._boxes[word].value and self._world is not None
        self._scene.switch(word, self._world if on else None)
        if word == "cameras":
            self._show_pictures(self._world if on else None)

    def _show_pictures(self, world: World | None) -> None:
        for picture in self._pictures:
            picture.remove()
        shown = camera_pictures(world) if world is not None else {}
        self._picture_folder.visible = bool(shown)
        with self._picture_folder:
            self._pictures = [
                self._server.viser.gui.add_image(picture, label=name)
                for name, picture in shown.items()
            ]

    # --- the episode

    def _choice_now(self) -> Choice:
        return Choice(self._player.value, int(self._seed.value), int(self._variation.value))

    def _play(self) -> None:
        choice = self._choice_now()
        self._outcome.content = f"{plain(choice.player)} plays …"
        try:
            self._recording = self._stage.play(choice, self._show_moment)
        except TaskbuilderError as error:
            self._say(error)
            return
        self._slider.max = self._recording.rollout.steps
        self._draw_charts(self._recording)
        self._go_to(0, pause=False)

    def _show_moment(self, moment: RecordedState) -> None:
        self._scene.place(moment.poses)
        self._lamps.content = conditions(moment.lamps)

    def _play_or_pause(self) -> None:
        recording = self._recording
        if recording is None:
            return
        if not self._playing and self._step >= recording.rollout.steps:
            self._step = 0.0
        self._playing = not self._playing

    def _step_by(self, count: int) -> None:
        self._go_to(int(self._step) + count, pause=True)

    def _go_to(self, step: int, *, pause: bool) -> None:
        recording = self._recording
        if recording is None:
            return
        step = max(0, min(step, recording.rollout.steps))
        self._step = float(step)
        self._playing = not pause
        self._show_step(recording, step)

    def _advance(self, seconds: float) -> None:
        """Play on for some seconds of wall time."""
        recording = self._recording
        if recording is None or not self._playing:
            return
        before = int(self._step)
        self._step += seconds * recording.control_hz * float(self._speed.value)
        if self._step >= recording.rollout.steps:
            self._step = float(recording.rollout.steps)
            self._playing = False
        if int(self._step) != before:
            self._show_step(recording, int(self._step))

    def _show_step(self, recording: Recording, step: int) -> None:
        moment = recording.moments[step]
        with self._server.viser.atomic():
            self._show_moment(moment)
            self._slider.value = step
            self._stages.content = stages(recording.rollout.stages, recording.rollout.stage[step])
            self._outcome.content = outcome(recording, step)

    def _draw_charts(self, recording: Recording) -> None:
        for chart in self._charts:
            chart.remove()
        rollout = recording.rollout
        seconds = np.arange(rollout.steps + 1) / rollout.control_hz
        sums = {
            label: np.concatenate([[0.0], np.cumsum(values)])
            for label, values in rollout.terms.items()
        }
        with self._chart_folder:
            self._charts = [self._chart("Reward terms, summed", seconds, sums)]
            if len(rollout.robot_force):
                force = {"force between robots (N)": rollout.robot_force.astype(float)}
                self._charts.append(self._chart("Force between robots", seconds, force))

    def _chart(self, title: str, seconds: Any, lines: dict[str, Any]) -> Any:
        series: list[dict[str, Any]] = [{"label": "s"}]
        series += [
            {"label": label, "stroke": COLORS[number % len(COLORS)], "width": 2}
            for number, label in enumerate(lines)
        ]
        return self._server.viser.gui.add_uplot(
            (seconds, *lines.values()),
            tuple(series),
            title=title,
            scales={"x": {"time": False}},
            legend={"show": True},
            aspect=1.6,
        )


MOVES: Mapping[str, Callable[[LivePage], None]] = {
    "◀": lambda page: page._step_by(-1),
    "play / pause": LivePage._play_or_pause,
    "▶": lambda page: page._step_by(1),
}
"""The buttons below the slider, and what they do."""

COLORS = ("#2563eb", "#ea7620", "#0d9488", "#9333ea", "#db2777", "#65850e", "#64748b", "#b45309")
