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
        return ", ".join([f"{_all(stage.together)} together: {_verb(stage)}", *_manner(stage)])
    if isinstance(stage, Wait):
        limit = f"for at most {number(stage.within)} s"
        return f"wait until the condition `{stage.until}` is true, {limit}"
    if isinstance(stage, Repeat):
        times = "once" if stage.repeat == 1 else f"{stage.repeat} times"
        times = f"at most {times}" if stage.unless else times
        end = f", until the condition `{stage.unless}` is true" if stage.unless else ""
        return f"{times}{end}:\n\n{numbered(stage.stages, indent)}"
    return "; ".join(
        f"`{robot}`: {', then '.join(', '.join([_verb(o), *_manner(o)]) for o in listed(told))}"
        for robot, told in stage.items()
    )


def _verb(order: Order | Together) -> str:
    if order.bring:
        return f"bring `{order.bring}` to {_height(order)}`{spelt(order.to)}`"
    if isinstance(order, Together):
        return ""
    if order.home:
        return "move to the start configuration"
    if order.posture:
        return f"move to the posture `{order.posture}`"
    if order.push:
        return f"push `{order.push}` to `{spelt(order.to)}`"
    if order.turn:
        return f"turn `{order.turn}` to {number(order.to_deg or 0.0)}°"
    if order.slide and isinstance(order.to, float):
        return f"slide `{order.slide}` to {_length(order.to)}"
    if order.press:
        if isinstance(order.to, float):
            return f"press `{order.press}` until the pressed joint is at {_length(order.to)}"
        deep = f" by {_length(order.depth)}" if order.depth is not None else ""
        return f"press `{order.press}` down{deep}"
    if order.retreat is not None:
        return f"move the tool back by {_length(order.retreat)}"
    if order.close:
        return f"close the gripper{f' on `{order.close}`' * (order.close != NOTHING)}"
    if order.release:
        return "let go of the object"
    if order.reach:
        return f"reach {'a point ' * bool(order.above)}{_height(order)}`{spelt(order.reach)}`"
    return f"{order.verb} `{spelt(getattr(order, order.verb))}`"


def _manner(order: Order | Together) -> Iterator[str]:
    """The settings of an order that differ from the defaults."""
    if any(order.offset):
        place = order.to if isinstance(order, Together) or order.reach is None else order.reach
        axes = "the world" if isinstance(place, tuple) else code(spelt(place))
        shift = ", ".join(number(value) for value in order.offset)
        yield f"offset by ({shift}) m along the axes of {axes}"
    if isinstance(order, Order):
        if order.approach is not None:
            yield f"with a straight approach of {_length(order.approach)}"
        if order.rpy_deg is not None:
            angles = ", ".join(number(angle) for angle in order.rpy_deg)
            yield f"with roll, pitch and yaw of the tool at ({angles})°"
        if order.align:
            yield f"with the orientation of `{spelt(order.to)}`"
        if order.until is not None:
            yield f"until the condition `{order.until}` is true"
        if not order.turn_tool:
            yield "without turning the tool"
    if order.straight:
        yield "in a straight line"
    if order.touching:
        yield f"contact with {_all(order.touching)} allowed"
    if order.speed != 1.0:
        yield f"at {number(order.speed * 100)} % of full speed"
    if order.tolerance is not None:
        yield f"with a tolerance of {_length(order.tolerance)}"
    if isinstance(order, Order) and order.tolerance_deg is not None:
        yield f"with a tolerance of {number(order.tolerance_deg)}°"


def _height(order: Order | Together) -> str:
    """How far above or below the named frame a motion ends, if it does not end there."""
    if not order.above:
        return ""
    return f"{_length(abs(order.above))} {'above' if order.above > 0 else 'below'} "


def _all(names: Sequence[str]) -> str:
    *others, last = map(code, names)
    return f"{', '.join(others)} and {last}" if others else last


def _length(metres: float) -> str:
    return f"{number(metres * 100)} cm" if metres >= 0.01 else f"{number(metres * 1000)} mm"
