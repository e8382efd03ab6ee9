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
        f"{cost.steps_per_second:,.0f} steps/s, overhead of {cost.overhead_physics_steps:.1f} "
        f"physics steps a control step, {reset_ms:.1f} ms a reset"
    )
    return FamilyResult("cost", checks, (), summary)
