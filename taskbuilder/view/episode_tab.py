"""The tab of an episode: who plays, the slider, what holds at each step, and charts."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from taskbuilder.errors import TaskbuilderError
from taskbuilder.view.recording import RecordedState, Recording
from taskbuilder.view.scene_tab import Ask, SceneTab
from taskbuilder.view.stage import Choice, Stage
from taskbuilder.view.words import conditions, outcome, plain, stages

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
        self.recording, self.playing = None, False
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
            self.recording = self._stage.play(choice, self._show_moment)
        except TaskbuilderError as error:
            self._explain(error)
            return
        self._slider.max = self.recording.rollout.steps
        self._draw_charts(self.recording)
        self.go_to(0, pause=False)

    def play_or_pause(self) -> None:
        """Play on, from the beginning if it was at its end, or pause."""
        recording = self.recording
        if recording is None:
            return
        if not self.playing and self.step >= recording.rollout.steps:
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
        step = max(0, min(step, recording.rollout.steps))
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
        if self.step >= recording.rollout.steps:
            self.step = float(recording.rollout.steps)
            self.playing = False
        if int(self.step) != before:
            self._show_step(recording, int(self.step))

    # --- showing

    def _show_moment(self, moment: RecordedState) -> None:
        self._scene.place(moment.poses)
        self._scene.touch(moment.contacts)
        self.lamps.content = conditions(moment.lamps)

    def _show_step(self, recording: Recording, step: int) -> None:
        moment = recording.moments[step]
        with self._server.atomic():
            self._show_moment(moment)
            self._slider.value = step
            self._stages.content = stages(recording.rollout.stages, recording.rollout.stage[step])
            self.outcome.content = outcome(recording, step)

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
