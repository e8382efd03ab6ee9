"""The page: its tabs, the requests of browsers, and the loop that updates it.

All physics run in the thread of `LivePage.run`. What a browser sends only puts a request into a
queue.
"""

from __future__ import annotations

import queue
import time
from collections.abc import Callable
from contextlib import suppress

from taskbuilder.env.parallel import TaskEnv
from taskbuilder.errors import Finding, TaskbuilderError
from taskbuilder.steering.session import Session
from taskbuilder.view.episode_tab import EpisodeTab
from taskbuilder.view.gamepads import Gamepads
from taskbuilder.view.place_tab import PlaceTab
from taskbuilder.view.scene_tab import SceneTab
from taskbuilder.view.server import PageServer
from taskbuilder.view.stage import Choice, Stage
from taskbuilder.view.steering_tab import SteeringTab
from taskbuilder.view.words import findings, heading, plain, subjects
from taskbuilder.world.visible import LinkPoses

PICTURES_HZ = 30
POLL_S = 0.1
"""Between looks at the files."""

MOST_REQUESTS = 100
"""Requests that wait; those of a browser that floods the page are dropped."""

MENDED = "the files have no errors any more"
BUILDING = "Building the scene …"
STALE = "✗ The files have errors since; this is the task as it was. See the tab *Findings*."

Request = Callable[[], None]


class LivePage:
    """A task on a page that follows its files.

    Args:
        stage: The task.
        server: The server of the page.
        choice: What is played first.

    Attributes:
        scene: The tab of the scene.
        episode: The tab of an episode.
        steering: The tab in which people steer robots.
        place: The tab in which things are moved by hand.
        findings: What is wrong with the files, as the page says it.

    Raises:
        TaskbuilderError: Episodes cannot be recorded where they should be.
    """

    def __init__(self, stage: Stage, server: PageServer, choice: Choice) -> None:
        self._stage, self._first_choice, self._server = stage, choice, server
        self._notified: tuple[Finding, ...] = ()
        self.requests: queue.Queue[Request] = queue.Queue(MOST_REQUESTS)
        gui = server.viser.gui
        self._heading = gui.add_markdown(BUILDING)
        tabs = gui.add_tab_group()
        episode, scene = tabs.add_tab("Episode"), tabs.add_tab("Scene")
        self.scene = SceneTab(
            server.viser, scene, ask=self.ask, picked=self._pick, shown=self._follow_scene
        )
        self.episode = EpisodeTab(
            server.viser,
            episode,
            self.ask,
            stage=stage,
            scene=self.scene,
            choice=choice,
            explain=self._explain,
        )
        self.steering = SteeringTab(
            server.viser,
            tabs.add_tab("Steer"),
            ask=self.ask,
            pads=Gamepads(server.gate, self.ask),
            begin=self._begin_steering,
        )
        self.place = PlaceTab(
            server.viser,
            tabs.add_tab("Place"),
            ask=self.ask,
            scene=self.scene,
            stop=self._stand_still,
        )
        with tabs.add_tab("Findings"):
            self.findings = gui.add_markdown("")
        self._show_task()

    # --- requests

    def ask(self, request: Request) -> None:
        """Have something done in the thread of the page; nothing if too much waits already."""
        with suppress(queue.Full):
            self.requests.put_nowait(request)

    def run(self, until: Callable[[], bool] = lambda: False) -> None:
        """Answer requests, follow the files, play and let people steer, until interrupted.

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
            self.episode.advance(now - last)
            last = now
            self._answer(min(self._steer(now), now + 1.0 / PICTURES_HZ))

    def _answer(self, until: float) -> None:
        """Answer requests: wait for one until a time, then take those that are there."""
        with suppress(queue.Empty):
            self.requests.get(timeout=max(until - time.monotonic(), 0.001))()
            for _ in range(MOST_REQUESTS):
                self.requests.get_nowait()()

    def close(self) -> None:
        """End what is steered, and free the world that is shown."""
        self.steering.close()
        self.scene.close()

    # --- the task

    def _reload(self) -> None:
        read = self._stage.load()
        self._say_findings()
        if not read:
            if self._stage.task is not None:
                self._heading.content = f"{heading(self._stage.task)}\n\n{STALE}"
            return
        try:
            self._show_task()
        except TaskbuilderError as error:
            self._server.notify(str(error))
            self.steering.show(None, str(error))

    def _show_task(self) -> None:
        task = self._stage.task
        self._say_findings()
        if task is None:
            return
        self._heading.content = heading(task)
        self.episode.clear()
        choice = self.episode.choice
        try:
            self.scene.show(task, choice.variation, choice.seed)
        except TaskbuilderError as error:
            self._explain(error)
            return
        self.steering.close()
        self.steering.show(self._stage.session(self._first_choice.player))

    def _say_findings(self) -> None:
        self.findings.content = findings(self._stage.findings)
        self.scene.light(subjects(self._stage.findings))
        count = len(self._stage.findings)
        if count:
            words = "1 finding" if count == 1 else f"{count} findings"
            self.episode.outcome.content = f"✗ {words}: see the tab *Findings*."
        before, self._notified = self._notified, self._stage.findings
        if before != self._notified:
            self._server.notify("\n".join(map(str, self._notified)) or MENDED)

    def _explain(self, error: TaskbuilderError) -> None:
        self._server.notify(str(error))
        found = self._stage.explain(error)
        self.scene.light(subjects(found))
        self.findings.content = findings(found) if found else f"✗ {plain(str(error))}"
        self.episode.outcome.content = f"✗ {plain(str(error))}"

    # --- moving things by hand

    def _pick(self, name: str) -> None:
        self.place.pick(name)

    def _follow_scene(self) -> None:
        self.place.show()

    def _stand_still(self) -> bool:
        """Show the initial state, unless people steer."""
        if self.steering.runs:
            return False
        self.episode.clear()
        self.scene.place_initially()
        return True

    # --- steering

    def _steer(self, now: float) -> float:
        """Run what people steer; when the next control step is due."""
        try:
            return self.steering.advance(now)
        except TaskbuilderError as error:
            self._explain(error)
            return now

    def _begin_steering(self, session: Session, seed: int | None) -> None:
        """Begin an episode with what is chosen in the tab *Episode*.

        Args:
            session: The session that it is of.
            seed: Its seed; None for the one that is chosen.
        """
        choice, task = self.episode.choice, self._stage.task
        if task is None:
            return
        self.episode.clear()
        if choice.variation != self.scene.variation:
            self.scene.show(task, choice.variation, choice.seed)
        session.begin(
            choice.player,
            choice.seed if seed is None else seed,
            self.scene.variation,
            _Follower(self.scene),
        )


class _Follower:
    """Shows each state of an environment as soon as it is reached."""

    def __init__(self, scene: SceneTab) -> None:
        self._scene = scene
        self._poses: LinkPoses | None = None

    def __call__(self, env: TaskEnv) -> None:
        if not env.episode.exploded:
            self._poses = self._poses or LinkPoses(env.episode.world)
            self._scene.place(self._poses.now())
