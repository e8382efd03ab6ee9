"""Twin Pegs: success and reward."""

from taskbuilder import description as d


class TwinPegs(d.Description):
    """Both pegs enter the socket at the same moment (within 0.5 s) and stay there, released."""

    left_in = d.Near("left_peg", "left_hole", within=0.015)
    right_in = d.Near("right_peg", "right_hole", within=0.015)
    together = d.Simultaneous(left_in, right_in, within=0.5)
    seated = left_in & right_in
    done = together & seated & d.Released("left_peg") & d.Released("right_peg")

    success = d.Sustained(done, seconds=0.5)
    failure = (
        d.Below("left_peg", height=0.3)
        | d.Below("right_peg", height=0.3)
        | d.ForceAbove("left", "right", newtons=100)
        | (seated & ~together)
    )
    stages = {
        "both held": d.Held("left_peg", by="left") & d.Held("right_peg", by="right"),
        "together in": together & seated,
        "done": done,
        "kept": success,
    }
    reward = (
        d.Distance("reach", "left.tcp", "left_peg.top", agent="left"),
        d.Distance("reach", "right.tcp", "right_peg.top", agent="right"),
        d.Distance("insert", "left_peg", "left_hole", 2.0, agent="left"),
        d.Distance("insert", "right_peg", "right_hole", 2.0, agent="right"),
        d.Bonus("seated", together & seated, 2.0),
        d.Bonus("done", done, 2.0),
    )
