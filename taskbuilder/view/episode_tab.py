"""The tab of an episode: who plays, the slider, what holds at each step, and charts."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from taskbuilder.errors import TaskbuilderError
from taskbuilder.view.recording import RecordedState, Recording
from taskbuilder.view.scene_tab import Ask, SceneTab
from taskbuilder.view.stage import Choice, Stage
from taskbuilder.view.words import conditions, outcome, plain, stages

NOBODY = "nobody"
"""No second episode beside the first."""

SPEEDS = ("0.25", "0.5", "1", "2", "4")


class EpisodeTab:
    """Plays episodes, and shows them at any step.

    Args:
        server: The server of viser.
        tab: The container that the controls stand in.
        ask: Has something done in the thread of the page.
        stage: The task.
        scene: Where the robots and objects are drawn.
        choice: What is chosen at first.
        explain: Called with an error.

    Attributes:
        recording: The episode that is shown, or None.
        beside: The episode of another player from the same seed, shown beside it, or None.
        step: The control step that is shown, with its fraction while it plays.
        playing: Whether it plays.
    """

    def __init__(
        self,
        server: Any,
        tab: Any,
        ask: Ask,
        *,
        stage: Stage,
        scene: SceneTab,
        choice: Choice,
        explain: Callable[[TaskbuilderError], None],
    ) -> None:
        self.recording: Recording | None = None
        self.beside: Recording | None = None
        self.step = 0.0
        self.playing = False
        self._server, self._stage, self._scene = server, stage, scene
        self._ask, self._explain = ask, explain
        with tab:
            self._make_controls(choice)

    def _make_controls(self, choice: Choice) -> None:
        gui = self._server.gui
        players = dict.fromkeys((*self._stage.players, choice.player))
        self._player = gui.add_dropdown("Player", tuple(players), initial_value=choice.player)
        self.other = gui.add_dropdown("Beside it", (NOBODY, *players))
        self._seed = gui.add_number("Seed", initial_value=choice.seed, min=0, step=1)
        self._variation = gui.add_number("Variation", initial_value=choice.variation, min=0, step=1)
        play = gui.add_button("Play an episode")
        self._slider = gui.add_slider("Step", min=0, max=1, step=1, initial_value=0)
        moves = gui.add_button_group("", tuple(MOVES))
        self._speed = gui.add_dropdown("Speed", SPEEDS, initial_value="1")
        self.outcome = gui.add_markdown("")
        self._stages = gui.add_markdown("")
        self.lamps = gui.add_markdown("")
        self.charts: list[Any] = []
        self._chart_folder = gui.add_folder("Rewards and forces")
        play.on_click(lambda _: self._ask(self.play))
        moves.on_click(lambda _: self._ask(lambda: MOVES[moves.value](self)))
        self._slider.on_update(self._scrubbed)

    def _scrubbed(self, event: Any) -> None:
        """Go to a step; only if a person moved the slider, not the page itself."""
        if event.client is not None:
            self._ask(lambda: self.go_to(self._slider.value, pause=True))

    @property
    def choice(self) -> Choice:
        """What is chosen now."""
        return Choice(self._player.value, int(self._seed.value), int(self._variation.value))

    def clear(self) -> None:
        """Show no episode."""
        self.recording, self.beside, self.playing = None, None, False
        self._scene.show_beside(on=False)
        task = self._stage.task
        self.outcome.content = "Press *Play an episode*."
        self._stages.content = stages(tuple(task.description.stages), 0) if task else ""
        self.lamps.content = ""

    # --- playing

    def play(self) -> None:
        """Play an episode and show it from its beginning."""
        choice, task = self.choice, self._stage.task
        self.outcome.content = f"{plain(choice.player)} plays …"
        try:
            if task is not None and choice.variation != self._scene.variation:
                self._scene.show(task, choice.variation, choice.seed)
            self._scene.show_beside(on=False)
            self.beside, self.recording = None, self._stage.play(choice, self._show_moment)
            if self.other.value != NOBODY:
                self._play_beside(replace(choice, player=self.other.value))
        except TaskbuilderError as error:
            self._explain(error)
            return
        self._slider.max = self.steps
        self._draw_charts(self.recording)
        self.go_to(0, pause=False)

    def _play_beside(self, choice: Choice) -> None:
        """Play another episode, and show it beside the first.

        Raises:
            TaskbuilderError: It cannot be played.
        """
        self._scene.show_beside(on=True)
        self.beside = self._stage.play(choice, lambda now: self._scene.place_beside(now.poses))

    @property
    def steps(self) -> int:
        """Number of control steps of the longer episode that is shown."""
        shown = (each for each in (self.recording, self.beside) if each is not None)
        return max((each.rollout.steps for each in shown), default=0)

    def play_or_pause(self) -> None:
        """Play on, from the beginning if it was at its end, or pause."""
        recording = self.recording
        if recording is None:
            return
        if not self.playing and self.step >= self.steps:
            self.step = 0.0
        self.playing = not self.playing

    def step_by(self, count: int) -> None:
        """Go some control steps on, or back."""
        self.go_to(int(self.step) + count, pause=True)

    def go_to(self, step: int, *, pause: bool) -> None:
        """Show a control step, and pause there or play on."""
        recording = self.recording
        if recording is None:
            return
        step = max(0, min(step, self.steps))
        self.step = float(step)
        self.playing = not pause
        self._show_step(recording, step)

    def advance(self, seconds: float) -> None:
        """Play on for some seconds of wall time."""
        recording = self.recording
        if recording is None or not self.playing:
            return
        before = int(self.step)
        self.step += seconds * recording.control_hz * float(self._speed.value)
        if self.step >= self.steps:
            self.step = float(self.steps)
            self.playing = False
        if int(self.step) != before:
            self._show_step(recording, int(self.step))

    # --- showing

    def _show_moment(self, moment: RecordedState) -> None:
        self._scene.place(moment.poses)
        self._scene.touch(moment.contacts)
        self.lamps.content = conditions(moment.lamps)

    def _show_step(self, recording: Recording, step: int) -> None:
        own = min(step, recording.rollout.steps)
        with self._server.atomic():
            self._show_moment(recording.moments[own])
            if self.beside is not None:
                self._scene.place_beside(self.beside.moments[: step + 1][-1].poses)
            self._slider.value = step
            self._stages.content = stages(recording.rollout.stages, recording.rollout.stage[own])
            self.outcome.content = outcome(recording, own, self.beside)

    def _draw_charts(self, recording: Recording) -> None:
        for chart in self.charts:
            chart.remove()
        rollout = recording.rollout
        seconds = np.arange(rollout.steps + 1) / rollout.control_hz
        sums = {
            label: np.concatenate([[0.0], np.cumsum(values)])
            for label, values in rollout.terms.items()
        }
        with self._chart_folder:
            self.charts = [self._chart("Reward terms, summed", seconds, sums)]
            if len(rollout.robot_force):
                force = {"force between robots (N)": rollout.robot_force.astype(float)}
                self.charts.append(self._chart("Force between robots", seconds, force))

    def _chart(self, title: str, seconds: Any, lines: dict[str, Any]) -> Any:
        series: list[dict[str, Any]] = [{"label": "s"}]
        series += [
            {"label": label, "stroke": COLORS[number % len(COLORS)], "width": 2}
            for number, label in enumerate(lines)
        ]
        return self._server.gui.add_uplot(
            (seconds, *lines.values()),
            tuple(series),
            title=title,
            scales={"x": {"time": False}},
            legend={"show": True},
            aspect=1.6,
        )


MOVES: Mapping[str, Callable[[EpisodeTab], None]] = {
    "◀": lambda tab: tab.step_by(-1),
    "play / pause": EpisodeTab.play_or_pause,
    "▶": lambda tab: tab.step_by(1),
}
"""The buttons below the slider, and what they do."""

COLORS = ("#2563eb", "#ea7620", "#0d9488", "#9333ea", "#db2777", "#65850e", "#64748b", "#b45309")
