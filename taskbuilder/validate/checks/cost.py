"""The cost family: measures speed, without a verdict."""

from __future__ import annotations

from taskbuilder.bench import measure_resets, measure_steps
from taskbuilder.validate.context import Context
from taskbuilder.validate.report import Check, FamilyResult

EPISODES, REPEATS = 1, 2
RESETS = 20


def cost_family(context: Context) -> FamilyResult:
    """Measure the time of steps, resets and building in this process, in a second or two."""
    cost = measure_steps(context.task, episodes=EPISODES, repeats=REPEATS)
    reset_ms = measure_resets(context.task, resets=RESETS)
    figures = (
        ("control steps", "steps_per_second", cost.steps_per_second, "1/s"),
        (
            "beyond its physics steps",
            "overhead_physics_steps",
            cost.overhead_physics_steps,
            "steps",
        ),
        ("a reset", "reset_ms", reset_ms, "ms"),
    )
    context.measures.update({key: value for _, key, value, _ in figures})
    checks = tuple(
        Check("TB561", name, True, value, None, unit) for name, _, value, unit in figures
    )
    summary = (
        f"{cost.steps_per_second:,.0f} steps/s, {overhead_in_words(cost.overhead_physics_steps)}, "
        f"{reset_ms:.1f} ms a reset"
    )
    return FamilyResult("cost", checks, (), summary)


def overhead_in_words(physics_steps: float) -> str:
    """The overhead of a control step; other work on the machine can make it seem negative."""
    if physics_steps < 0.05:
        return "no measurable overhead"
    return f"overhead of {physics_steps:.1f} physics steps a control step"
