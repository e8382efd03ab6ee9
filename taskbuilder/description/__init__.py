"""Success and reward: conditions, rewards, and descriptions made of them.

Everything that a description file needs is importable from here.
"""

import warnings

from taskbuilder.description.contact import Contact, EmptyHanded, ForceAbove, Held, On, Released
from taskbuilder.description.custom import condition
from taskbuilder.description.description import Description, Outcome
from taskbuilder.description.joints import JointAngle, JointPosition, JointTravel
from taskbuilder.description.logic import (
    All,
    Any,
    AtLeast,
    Never,
    Once,
    Simultaneous,
    Sustained,
    Then,
)
from taskbuilder.description.measures import (
    Closeness,
    ContactForce,
    Count,
    Duration,
    Fraction,
    Gap,
    GripperOpening,
    Height,
    Ladder,
    Mean,
    Measure,
    Minimum,
    Speed,
    Tilt,
    measure,
)
from taskbuilder.description.node import (
    BodyName,
    Condition,
    ContainerName,
    FrameName,
    JointName,
    ObjectName,
    RobotName,
    SiteName,
    SolidName,
)
from taskbuilder.description.rewards import Bonus, Distance, Paid, Potential, Term
from taskbuilder.description.space import (
    Above,
    Below,
    Beyond,
    Inside,
    Level,
    Moved,
    Near,
    Stationary,
    Turned,
    Upright,
)
from taskbuilder.description.view import WorldView

__all__ = [
    "Above",
    "All",
    "Any",
    "AtLeast",
    "Below",
    "Beyond",
    "BodyName",
    "Bonus",
    "Closeness",
    "Condition",
    "Contact",
    "ContactForce",
    "ContainerName",
    "Count",
    "Description",
    "Distance",
    "Duration",
    "EmptyHanded",
    "ForceAbove",
    "Fraction",
    "FrameName",
    "Gap",
    "GripperOpening",
    "Height",
    "Held",
    "Inside",
    "JointAngle",
    "JointName",
    "JointPosition",
    "JointTravel",
    "Ladder",
    "Level",
    "Mean",
    "Measure",
    "Minimum",
    "Moved",
    "Near",
    "Never",
    "ObjectName",
    "On",
    "Once",
    "Outcome",
    "Paid",
    "Potential",
    "Released",
    "RobotName",
    "Simultaneous",
    "SiteName",
    "SolidName",
    "Speed",
    "Stationary",
    "Sustained",
    "Term",
    "Then",
    "Tilt",
    "Turned",
    "Upright",
    "WorldView",
    "condition",
    "measure",
]

_RENAMED = {"Least": "Minimum", "Share": "Fraction"}
"""Names that descriptions may have been written with, kept for one version."""


def __getattr__(name: str) -> object:
    if name not in _RENAMED:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    new = _RENAMED[name]
    warnings.warn(f"{name} is called {new} now", FutureWarning, stacklevel=2)
    return globals()[new]
