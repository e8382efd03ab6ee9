"""The codes of findings about assets, with the explanation that the documentation shows."""

from __future__ import annotations

MISSING = "TB401"
OUTSIDE = "TB402"
NOT_READABLE = "TB403"
BAD_MESH = "TB404"
MESH_FORMAT = "TB405"
CRASHED = "TB406"
ENGINE_WARNING = "TB407"
XML = "TB410"
STRUCTURE = "TB411"
NAME = "TB412"
NUMBER = "TB413"
MASS = "TB414"
INERTIA = "TB415"
JOINT = "TB416"
LIMIT = "TB417"
GEOMETRY = "TB418"
TREE = "TB419"
IGNORED = "TB420"
TOO_MANY = "TB421"

CODES: dict[str, tuple[str, str]] = {
    MISSING: (
        "Asset not found",
        "A file names another one that does not exist. Write its path relative to the file that "
        "names it, or as package://NAME/…, where NAME is a folder beside or above that file.",
    ),
    OUTSIDE: (
        "Asset outside the allowed folders",
        "An asset may come only from the folder of the task or robot that uses it, or from "
        "pybullet_data, so that a task works on every machine. Copy the file there and write its "
        "path relative to the file that names it; absolute paths and URLs are refused.",
    ),
    NOT_READABLE: (
        "Asset cannot be read",
        "The path leads to a folder, to a file without permission to read, to one that is too "
        "large, or to one of another type than its name says.",
    ),
    BAD_MESH: (
        "Mesh is invalid",
        "The mesh has no faces, a face refers to a vertex that does not exist, a number is not "
        "finite, or its size is absurd. The physics engine would end the process or load it "
        "without a collision shape. Export it again from the modelling tool.",
    ),
    MESH_FORMAT: (
        "Mesh format not supported",
        "Meshes are read from OBJ and binary STL. Other formats, ASCII STL and DAE among them, "
        "are misread by the physics engine or end the process: convert them to OBJ.",
    ),
    CRASHED: (
        "Asset crashed the physics engine",
        "Loading the asset in a process of its own ended that process, hung, or was refused by "
        "the physics engine. Simplify the asset until it loads.",
    ),
    ENGINE_WARNING: (
        "The physics engine warned",
        "The asset was loaded, and the physics engine printed a warning that usually means that "
        "a part of it was replaced by a default. Mend what the message names.",
    ),
    XML: (
        "Not well-formed XML",
        "The URDF is not well-formed, has a document type declaration, or is nested or long "
        "beyond what any robot needs. Run xacro files through xacro first.",
    ),
    STRUCTURE: (
        "Unexpected URDF structure",
        "An element or attribute that a URDF must have is missing, or appears more often than it "
        "may; the physics engine would read only the first.",
    ),
    NAME: (
        "Bad or repeated name",
        "Every link and every joint needs a name of its own, of at most 128 characters. The "
        "physics engine ends the process on two joints of one name.",
    ),
    NUMBER: (
        "Not a number",
        "A value is not a plain finite number in the range that makes sense, or not as many "
        "numbers as are needed. Decimals take a point: the physics engine reads 1,5 as 1.",
    ),
    MASS: (
        "Implausible or missing mass",
        "A link moved by its joint needs a mass above 0 and at most 1000 kg. Without <inertial> "
        "the physics engine takes 1 kg, and with a mass of 0 the link stands still.",
    ),
    INERTIA: (
        "Impossible inertia",
        "The principal moments of inertia of a body are above 0, and none exceeds the sum of the "
        "other two. Compute them from the shape and mass of the link.",
    ),
    JOINT: (
        "Bad joint",
        "A joint is revolute, continuous, prismatic or fixed, joins two links of the file, and "
        "has an axis of non-zero length unless it is fixed.",
    ),
    LIMIT: (
        "Bad joint limits",
        "A revolute or prismatic joint needs <limit lower=… upper=… effort=… velocity=…/> with "
        "lower at most upper and neither effort nor velocity below 0.",
    ),
    GEOMETRY: (
        "Bad geometry",
        "A <geometry> holds exactly one of box, sphere, cylinder, capsule and mesh, with sizes "
        "above 0.",
    ),
    TREE: (
        "Links do not form a tree",
        "Exactly one link, the root, is no joint's child; every other link is the child of one "
        "joint. The physics engine ends the process on two roots or two parents.",
    ),
    IGNORED: (
        "Element is ignored",
        "The element is not one that is passed to the physics engine. It may be misspelt.",
    ),
    TOO_MANY: (
        "Too many links",
        "The physics engine has room for 128 links of a URDF, and writes past its end with more. "
        "Join links that do not move against each other.",
    ),
}
