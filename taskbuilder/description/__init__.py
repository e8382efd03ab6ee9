"""What counts as success and what is paid: conditions, rewards, and descriptions made of them.

Everything that a description file needs is importable from here.
"""

from taskbuilder.description.contact import Contact, EmptyHanded, Held, On, Released
from taskbuilder.description.description import Description, Outcome
from taskbuilder.description.logic import AtLeast, Never, Once, Sustained, Then
from taskbuilder.description.measures import (
    Closeness,
    Gap,
    GripperOpening,
    Height,
    Ladder,
    Least,
    Measure,
    Share,
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
    condition,
)
from taskbuilder.description.rewards import Bonus, Distance, Paid, Potential, Term
from taskbuilder.description.space import (
    Above,
    Below,
    Inside,
    JointAngle,
    JointPosition,
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
    "AtLeast",
    "Below",
    "BodyName",
    "Bonus",
    "Closeness",
    "Condition",
    "Contact",
    "ContainerName",
    "Description",
    "Distance",
    "EmptyHanded",
    "FrameName",
    "Gap",
    "GripperOpening",
    "Height",
    "Held",
    "Inside",
    "JointAngle",
    "JointName",
    "JointPosition",
    "Ladder",
    "Least",
    "Level",
    "Measure",
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
    "Share",
    "SiteName",
    "Stationary",
    "Sustained",
    "Term",
    "Then",
    "Turned",
    "Upright",
    "WorldView",
    "condition",
    "measure",
]
