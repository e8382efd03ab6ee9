"""Codes of rewards and progress: TB55x."""

from __future__ import annotations

from taskbuilder.diagnostics.entry import Code, Example

ENTRIES = {
    "TB551": Code(
        "Reward term not finite or too large",
        "A reward term is not a finite number, or its absolute value exceeds one million at a "
        "control step. Next to such a large term, the other terms would be lost to rounding in "
        "single precision.",
        Example(
            "description",
            'reward = (Distance("carry", "cube", "goal", 1e8), Distance("point", "right.tcp", '
            '"lamp"))',
            'reward = (Distance("carry", "cube", "goal", 1.0), Distance("point", "right.tcp", '
            '"lamp"))',
        ),
    ),
    "TB552": Code(
        "Stalling earns as much as continuing",
        "If all robots hold still after one of the expert's stages, they do not earn "
        "significantly less than the expert. A learner would stop after this stage. To test "
        "significance, `validate` compares the returns of episodes with the same seed in pairs. "
        "The 95 % confidence interval of the expert's mean lead must lie above zero. Give more "
        "reward for later stages, or less for earlier ones.",
        Example(
            "description",
            'reward = (Bonus("hold", Held("cube") & ~success, 1.0), Bonus("done", success, 0.1))',
            'reward = (Bonus("hold", Held("cube") & ~success, 1.0), Bonus("done", success, 4.0))',
        ),
    ),
    "TB553": Code(
        "Doing nothing or acting at random earns as much",
        "Holding still from the start, or acting at random, does not earn significantly less than "
        "the expert (see TB552).",
        Example(
            "description",
            'reward = (Distance("carry", "cube", "goal", -1.0), Bonus("done", success, 0.1))',
            'reward = (Distance("carry", "cube", "goal", 1.0), Bonus("done", success, 1.0))',
        ),
    ),
    "TB554": Code(
        "Leaving out a robot earns as much",
        "The task requires cooperation, but with one robot holding still, the team does not earn "
        "significantly less than the expert (see TB552). A learner would leave that robot idle.",
        Example(
            "description",
            'reward = (Distance("carry", "cube", "goal", 4.0), Distance("rest", "right.tcp", '
            '"right.base"))',
            'reward = (Distance("carry", "cube", "goal", 4.0), Distance("point", "right.tcp", '
            '"lamp"))',
        ),
    ),
    "TB555": Code(
        "Failing on purpose earns as much",
        "Dropping or throwing the held objects after one of the expert's stages does not earn "
        "significantly less than the expert (see TB552). To drop the objects, all robots open "
        "their grippers. To throw them, all arms swing sideways at full speed, and the grippers "
        "open during the swing. Each of the two is played on half of the seeds. Episodes that "
        "succeed nevertheless are not compared. A possible cause is a bonus that is also paid "
        "after a failure. In this case, write `Bonus(..., done & ~Once(failure))`. Another "
        "possible cause is a failure that ends the episode and so avoids negative rewards.",
        Example(
            "description",
            'reward = (Distance("carry", "cube", "goal"), Distance("point", "right.tcp", "lamp"), '
            'Bonus("let go", Once(Held("cube")) & Released("cube"), 5.0))',
            'reward = (Distance("carry", "cube", "goal"), Distance("point", "right.tcp", "lamp"), '
            'Bonus("let go", success & Released("cube"), 5.0))',
        ),
    ),
    "TB556": Code(
        "Progress is higher before success",
        "In an episode in which the expert succeeds, the description's `progress` is lower at "
        "success than at an earlier control step. A training reward based on progress would then "
        "pay nothing for the last step to success, or even penalise it. A common cause is a rung "
        "of a `Ladder` that is worth less than the rung below it, or whose condition does not "
        "hold at success.",
        Example(
            "description",
            'progress = Ladder(Closeness("left.tcp", "cube"), (Held("cube"), 3.0), (success, 2.0))',
            'progress = Ladder(Closeness("left.tcp", "cube"), (Held("cube"), 2.0), (success, 3.0))',
        ),
    ),
    "TB557": Code(
        "Setback although the expert succeeds",
        "The description's `setback` holds in an episode in which the expert succeeds. A setback "
        "can end a training episode with a penalty, so training would punish the robots for what "
        "the expert does. In the wrong example, `Sustained` measures the time from the start of "
        "the episode and not from the grasp, so `Then` may hold as soon as the cube is grasped.",
        Example(
            "description",
            'setback = Then(Held("cube"), Sustained(~success, seconds=2.0))',
            'setback = Sustained(Once(Held("cube")) & ~success, seconds=2.0)',
        ),
    ),
    "TB558": Code(
        "The expert waits much longer in some episodes",
        "Training ends an episode in which the progress has not risen for 1.5 times the longest "
        "wait of the expert, which it measures on 20 episodes. In some other episode, in which the "
        "expert succeeds, it waits for longer than that, so training would end this episode before "
        "its success. Without `progress`, that of the expert's stages counts. Times are those of "
        "episodes with the same variation. Let the progress rise while the expert waits, for "
        'example by a rung such as `(Held("cube"), Closeness("cube", "goal"))` instead of '
        '`(Held("cube"), 1.0)`, or let the expert wait alike in every episode.',
    ),
    "TB559": Code(
        "A lead is nearly a tie",
        "The expert earns more than every probe, but its lead over one of them is less than 2 % of "
        "its largest lead at the same discount, which is usually the lead over doing nothing. A "
        "learner that has come as far as this probe gains next to nothing by finishing the task. "
        "Pay more for the stages that the probe leaves out, or less for those that it does. This "
        "is a warning.",
        Example(
            "description",
            'reward = (Distance("carry", "cube", "goal", 0.01), Bonus("hold", Held("cube"), 1.0))',
            'reward = (Distance("carry", "cube", "goal", 0.01), Bonus("hold", Held("cube"), 1.0), '
            'Bonus("done", success, 4.0))',
        ),
    ),
}
"""Code -> what it stands for."""
