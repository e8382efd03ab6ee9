"""Gatekeeper: success and reward."""

from taskbuilder import description as d


class Gatekeeper(d.Description):
    """The crate stands in the yard and the gate, which springs shut, is closed behind it."""

    gripped = d.Held("gate.panel", by="keeper")
    opened = d.JointPosition("gate.slide", above=0.28)
    shut = d.JointPosition("gate.slide", below=0.02)
    arrived = d.Near("crate", "yard", within=0.05, axes="xy") & d.Upright("crate", within_deg=10)
    done = arrived & shut & d.Released("gate") & d.Released("crate") & d.Stationary("crate")

    success = d.Sustained(done, seconds=1.0)
    failure = (
        d.Below("crate", height=0.35)
        | d.ForceAbove("pusher", "keeper", newtons=100)
        | d.ForceAbove("pusher", "gate", newtons=60)
    )
    stages = {"open": opened, "in the yard": arrived, "gate let shut": done, "kept shut": success}
    reward = (
        d.Distance("reach", "keeper.tcp", "gate.knob", 0.3, agent="keeper"),
        d.Distance("push", "crate", "yard"),
        d.Bonus("open", opened | arrived, 0.3, agent="keeper"),
        d.Bonus("in the yard", arrived, 0.5, agent="pusher"),
        d.Bonus("shut", done & ~d.Once(failure), 3.0),
    )

    progress = d.Ladder(
        d.Closeness("keeper.tcp", "gate.knob"),
        (gripped, 1.2 + d.Closeness("keeper.tcp", "keeper.base", scale=0.5)),
        (opened, 2.4 + d.Closeness("crate", "yard", scale=0.3)),
        (arrived, 3.5 + 0.5 * d.Closeness("pusher.tcp", "pusher.base", scale=0.5)),
        (arrived & shut, 4.2 + 0.5 * d.GripperOpening("keeper")),
        (done, 5.0 + d.Fraction(d.Duration(done), of=1.0)),
        (success, 6.5),
    )
