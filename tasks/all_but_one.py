"""All but One: success and reward."""

from taskbuilder import description as d

OTHERS = ("left_tin", "near_tin", "far_tin")


def cleared(tin: str) -> d.Condition:
    """A tin stands in a crate, and nobody holds it."""
    return (d.Inside(tin, "left_crate") | d.Inside(tin, "right_crate")) & d.Released(tin)


class AllButOne(d.Description):
    """Each arm reaches the tins of its half only; the tin that is named stays where it is."""

    first = d.AtLeast(1, *(cleared(tin) for tin in OTHERS))
    two = d.AtLeast(2, *(cleared(tin) for tin in OTHERS))
    done = d.All(*(cleared(tin) for tin in OTHERS))

    success = d.Sustained(done, seconds=1.0)
    failure = (
        d.Moved("kept", by=0.04)
        | d.Any(*(d.Below(tin, height=0.35) for tin in OTHERS))
        | d.ForceAbove("left", "right", newtons=100)
    )
    stages = {"one cleared": first, "two cleared": two, "all cleared": done, "kept so": success}
    reward = (
        d.Distance("reach", "left.tcp", "left_tin", 0.5, agent="left"),
        d.Distance("carry", "left_tin", "left_spot", agent="left"),
        d.Distance("carry near", "near_tin", "outer_spot", agent="right"),
        d.Distance("carry far", "far_tin", "inner_spot", agent="right"),
        *(d.Bonus(f"cleared {tin}", cleared(tin), 0.6) for tin in OTHERS),
        d.Bonus("done", done, 2.0),
    )

    near = (
        d.Closeness("left_tin", "left_spot")
        + d.Closeness("near_tin", "outer_spot")
        + d.Closeness("far_tin", "inner_spot")
    )
    progress = d.Ladder(
        0.5 * d.Closeness("left.tcp", "left_tin.grasp")
        + 0.5 * d.Closeness("right.tcp", "near_tin.grasp")
        + near,
        (done, 4.0 + d.Fraction(d.Duration(done), of=1.0)),
        (success, 6.0),
    )
