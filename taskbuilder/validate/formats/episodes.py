"""Pictures on a page: the cameras, the expert's film strip, and episodes that went wrong."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Iterator, Sequence

from taskbuilder.rollout.record import Rollout
from taskbuilder.schema.expert import ExpertStage, Order, Repeat, Together, Wait, orders_of
from taskbuilder.validate.formats.markup import Content, Html, element
from taskbuilder.validate.formats.pictures import Failure, Moment, Picture, Pictures
from taskbuilder.validate.formats.words import number

Does = tuple[str, str]
"""Who does what: ``("left", "grasp stick.left_end")``."""


def image(picture: Picture, text: str) -> Html:
    """A picture as part of the page itself."""
    data = b64encode(picture.jpeg).decode("ascii")
    source = f"data:image/jpeg;base64,{data}"
    return element("img", src=source, width=picture.width, height=picture.height, alt=text)


def camera(picture: Picture) -> Html:
    """What a camera sees."""
    shown = image(picture, f"The scene from the camera {picture.name}")
    return element("figure", shown, element("figcaption", picture.name))


def cameras(scene: Sequence[Picture]) -> Html:
    """What several cameras see."""
    return element("div", [camera(picture) for picture in scene], class_="cameras")


def expert(stages: Sequence[ExpertStage], pictures: Pictures) -> Html:
    """The expert's stages, each with a picture of its end where there is one."""
    shown = pictures.shown
    if shown is None or not pictures.strip:
        return element("ol", [element("li", _stage(n, stages)) for n in _numbers(stages)])
    first = shown.first_success
    solved = next((m.step for m in pictures.strip if first is not None and m.step >= first), None)
    frames = [_frame(moment, stages, solved=moment.step == solved) for moment in pictures.strip]
    return element("ol", frames, class_="strip")


def _numbers(stages: Sequence[ExpertStage]) -> range:
    return range(1, len(stages) + 1)


def _frame(moment: Moment, stages: Sequence[ExpertStage], *, solved: bool) -> Html:
    words: list[Content] = [_stage(number, stages) for number in moment.stages]
    if not moment.step:
        words.append(element("p", "The episode begins"))
    if solved:
        words.append(element("p", "Solved", class_="solved"))
    time = f"{moment.seconds:.1f} s"
    caption = element("div", words, element("time", time), class_="caption")
    return element("li", image(moment.picture, f"After {time}"), caption)


def _stage(number: int, stages: Sequence[ExpertStage]) -> Html:
    orders = _orders(stages[number - 1]) if number <= len(stages) else None
    return element("div", element("span", str(number), class_="number"), orders, class_="stage")


def _orders(stage: ExpertStage) -> Html:
    return element(
        "ul",
        [element("li", element("b", who), " ", what) for who, what in does(stage)],
        class_="orders",
    )


def does(stage: ExpertStage) -> list[Does]:
    """Who does what in a stage; the stages of one that repeats follow it."""
    if isinstance(stage, Wait):
        return [("all", f"wait {stage}, at most {stage.within:g} s")]
    if isinstance(stage, Repeat):
        unless = f", unless {stage.unless}" if stage.unless else ""
        inner = [pair for part in stage.stages for pair in does(part)]
        return [("all", f"{stage}{unless}:"), *inner]
    return [(who, f"{order}{_beside(order)}") for who, order in orders_of(stage)]


def _beside(order: Order | Together) -> str:
    return f", {number(100 * order.above)} cm above" if order.above else ""


def failures(listed: Sequence[Failure]) -> Html:
    """Episodes that went wrong, with a picture of when it showed."""
    return element("ol", [_failure(failure) for failure in listed], class_="failures")


def _failure(failure: Failure) -> Html:
    demo, moment = failure.rollout, failure.moment
    seed = f"seed {demo.seed}" + (f", variation {demo.variation}" if demo.variation else "")
    words = [
        element("p", element("b", seed), element("span", failure.family), class_="which"),
        *_reasons(demo),
    ]
    if moment is None:
        return element("li", element("div", words, class_="caption"))
    time = f"after {moment.seconds:.1f} s, step {moment.step} of {demo.steps}"
    caption = element("div", words, element("time", time), class_="caption")
    return element("li", image(moment.picture, f"The episode {time}"), caption)


def _reasons(demo: Rollout) -> Iterator[Html]:
    if demo.success:
        yield element("p", "Solved, though it should not have been.")
    if demo.trouble:
        yield element(
            "p",
            element("span", str(demo.trouble.stage), class_="number"),
            f"{demo.trouble.order}: {demo.trouble.cause}",
        )
        yield element("p", f"{demo.trouble.message}.", class_="quiet")
    elif not demo.success:
        reached = (
            f"“{demo.furthest_stage}” was reached" if demo.furthest_stage else "nothing was reached"
        )
        yield element("p", f"Every stage was played, yet the task was not solved; {reached}.")
    if not demo.success and demo.why:
        yield element("ul", [element("li", str(reason)) for reason in demo.why], class_="quiet")
