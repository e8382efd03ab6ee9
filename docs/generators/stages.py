"""The stages of experts in words."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from taskbuilder.reference.markdown import code, number
from taskbuilder.schema.expert import ExpertStage, Repeat, Together, Wait, listed
from taskbuilder.schema.order import NOTHING, Order, spelt


def numbered(stages: Sequence[ExpertStage], indent: str = "") -> str:
    """Stages as a numbered list; those that repeat, as a list within it."""
    return "\n".join(f"{indent}1. {_stage(stage, f'{indent}   ')}" for stage in stages)


def _stage(stage: ExpertStage, indent: str) -> str:
    if isinstance(stage, Together):
        who = " and ".join(map(code, stage.together))
        return ", ".join([f"{who} together: {_verb(stage)}", *_manner(stage)])
    if isinstance(stage, Wait):
        return f"wait until `{stage.until}` holds, {number(stage.within)} s at most"
    if isinstance(stage, Repeat):
        times = "once" if stage.repeat == 1 else f"{stage.repeat} times"
        end = f", until `{stage.unless}` holds" if stage.unless else ""
        return f"{times}{end}:\n\n{numbered(stage.stages, indent)}"
    return "; ".join(
        f"`{robot}`: {', then '.join(', '.join([_verb(o), *_manner(o)]) for o in listed(told))}"
        for robot, told in stage.items()
    )


def _verb(order: Order | Together) -> str:
    if order.bring:
        return f"bring `{order.bring}` to `{spelt(order.to)}`"
    if isinstance(order, Together):
        return ""
    if order.home:
        return "go home"
    if order.posture:
        return f"take the posture `{order.posture}`"
    if order.push:
        return f"push `{order.push}` to `{spelt(order.to)}`"
    if order.turn:
        return f"turn `{order.turn}` to {number(order.to_deg or 0.0)}°"
    if order.slide and isinstance(order.to, float):
        return f"slide `{order.slide}` to {_length(order.to)}"
    if order.press:
        to = f" to {_length(order.to)}" if isinstance(order.to, float) else ""
        return f"press `{order.press}`{to}"
    if order.retreat is not None:
        return f"retreat {_length(order.retreat)}"
    if order.close:
        return "close on nothing" if order.close == NOTHING else f"close on `{order.close}`"
    if order.release:
        return "release"
    return f"{order.verb} `{spelt(getattr(order, order.verb))}`"


def _manner(order: Order | Together) -> Iterator[str]:
    """The settings of an order that differ from the defaults."""
    if any(order.offset):
        yield f"offset by ({', '.join(number(value) for value in order.offset)}) m"
    if order.above:
        yield f"{_length(abs(order.above))} {'above' if order.above > 0 else 'below'}"
    if isinstance(order, Order):
        if order.approach is not None:
            yield f"straight in from {_length(order.approach)} away"
        if order.rpy_deg is not None:
            yield f"turned to ({', '.join(number(angle) for angle in order.rpy_deg)})°"
        if order.align:
            yield "turned like that frame"
        if not order.turn_tool:
            yield "without turning the tool"
        if order.depth is not None:
            yield f"{_length(order.depth)} deep"
    if order.straight:
        yield "in a straight line"
    if order.touching:
        *others, last = map(code, order.touching)
        yield f"may touch {', '.join(others)} and {last}" if others else f"may touch {last}"
    if order.speed != 1.0:
        yield f"at {number(order.speed * 100)} % of full speed"
    if order.tolerance is not None:
        yield f"to within {_length(order.tolerance)}"


def _length(metres: float) -> str:
    return f"{number(metres * 100)} cm" if metres >= 0.01 else f"{number(metres * 1000)} mm"
