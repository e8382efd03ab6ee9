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
PLACEHOLDER = "TB422"
CENTER_OF_MASS = "TB423"
NO_COLLISION = "TB424"
FILLED = "TB425"
XACRO = "TB430"
AMBIGUOUS = "TB431"
UNIT = "TB432"
NOT_IMPORTED = "TB433"
NOT_HELD = "TB440"
UNTOUCHING = "TB441"
STROKE = "TB442"
FLYING = "TB443"
FORCE_LOST = "TB444"
TOOL_POINT = "TB445"
SAGGING = "TB446"

CODES: dict[str, tuple[str, str]] = {
    MISSING: (
        "Asset not found",
        "A file refers to another file that does not exist. Write the path of the other file "
        "relative to the file that refers to it, or as `package://NAME/…`, where NAME is a folder "
        "beside or above the file that refers to it, inside the allowed folders.",
    ),
    OUTSIDE: (
        "Asset outside the allowed folders",
        "An asset must be in the folder of the task or robot that uses it, in a folder given by "
        "`--task-path` or `TASKBUILDER_PATH`, in the ROS package of the URDF that refers to it "
        "(the nearest folder above with a `package.xml`), or in the package pybullet_data. Copy "
        "the asset to the folder of the task or robot, and write its path relative to the file "
        "that refers to it. Absolute paths and URLs are refused, because they do not work on "
        "every machine.",
    ),
    NOT_READABLE: (
        "Asset cannot be read",
        "The path leads to a folder, to a file that you have no permission to read, to a file that "
        "is too large, or to a file whose type does not match its extension.",
    ),
    BAD_MESH: (
        "Invalid mesh",
        "The mesh has no faces, a face refers to a vertex that does not exist, a coordinate is "
        "not finite, or the size is implausible. The physics engine would crash, or load the mesh "
        "without a collision shape. Export the mesh again from your modelling tool.",
    ),
    MESH_FORMAT: (
        "Unsupported mesh format",
        "Only OBJ and binary STL are supported. The physics engine misreads other formats, such "
        "as ASCII STL and DAE, or crashes on them. Convert the mesh to OBJ.",
    ),
    CRASHED: (
        "Asset crashed the physics engine",
        "Assets are first loaded in a separate process, as a test. This process crashed or hung, "
        "or the physics engine refused the asset. Simplify the asset until it loads.",
    ),
    ENGINE_WARNING: (
        "Warning from the physics engine",
        "The physics engine issued a warning. The asset was loaded, but the warning usually means "
        "that the engine replaced part of it with a default. Correct the part that the message "
        "names.",
    ),
    XML: (
        "Not well-formed XML",
        "The URDF is not well-formed XML, has a document type declaration, has a line of more "
        "than 8,000 characters, or has elements nested more than 32 levels deep. If the file uses "
        "xacro, convert it with xacro first.",
    ),
    STRUCTURE: (
        "Unexpected URDF structure",
        "The root element is not `<robot>`, there is no `<link>`, or an element appears twice "
        "where only one is allowed. The physics engine would read only the first of the two.",
    ),
    NAME: (
        "Invalid or duplicate name",
        "Every link and every joint needs a unique name of at most 128 bytes. The robot needs a "
        "name as well. The physics engine crashes if two joints have the same name.",
    ),
    NUMBER: (
        "Invalid number",
        "The value of an attribute is not numeric, is not finite, is implausibly large, or has "
        "too many or too few components. Use a decimal point: the physics engine reads `1,5` as 1.",
    ),
    MASS: (
        "Implausible or missing mass",
        "A link that moves needs a mass above 0 and at most 1000 kg. Without `<inertial>`, "
        "the physics engine assumes 1 kg, and with a mass of 0 the link does not move. An object "
        "whose root has no mass needs `fixed: true`, because it is immovable.",
    ),
    INERTIA: (
        "Impossible inertia",
        "All three principal moments of inertia must be above 0, and none may exceed the sum of "
        "the other two. Compute the moments from the shape and mass of the link.",
    ),
    JOINT: (
        "Invalid joint",
        "A joint must be revolute, continuous, prismatic or fixed, and must connect two links of "
        "the file. If a joint is not fixed, its axis must have a non-zero length. A joint can "
        "mimic only another joint that moves.",
    ),
    LIMIT: (
        "Invalid joint limits",
        "A revolute or prismatic joint needs `<limit lower=… upper=… effort=… velocity=…/>`. "
        "`lower` must not exceed `upper`, and `effort` and `velocity` must not be negative.",
    ),
    GEOMETRY: (
        "Invalid geometry",
        "Every `<visual>` and `<collision>` needs one `<geometry>` with exactly one box, sphere, "
        "cylinder, capsule or mesh, with sizes above 0.",
    ),
    TREE: (
        "Links do not form a tree",
        "The links must form a tree: exactly one link, the root, has no parent joint, and every "
        "other link has exactly one parent joint. The physics engine crashes if there are two "
        "roots, or if a link has two parents.",
    ),
    IGNORED: (
        "Ignored element",
        "The URDF has an element that is not allowed at this place. The element is not passed to "
        "the physics engine. The name of the element may be misspelt.",
    ),
    TOO_MANY: (
        "Too many links",
        "The physics engine supports at most 128 links in a URDF and corrupts memory beyond "
        "that. Merge links that do not move relative to each other.",
    ),
    PLACEHOLDER: (
        "Implausible inertia",
        "The moments of inertia of a link of an object differ by a factor of more than 20 from "
        "those of its shape with uniform density, or exceed what the mass and the shape allow: "
        "no moment can exceed the mass times the square of the largest distance from the centre "
        "of mass. Such placeholders, often 1 kg·m² about each axis, are common in published "
        "files. The object resists turning like a flywheel, and may remain tilted on its edge. "
        "Write the moments that the message gives.",
    ),
    CENTER_OF_MASS: (
        "Centre of mass outside the body",
        "The centre of mass of a link of an object lies far outside the box around its shapes: "
        "by more than half the diagonal of the box. Correct `<inertial><origin xyz=…/>`, which "
        "is in the frame of the link, in metres.",
    ),
    NO_COLLISION: (
        "No collision shape",
        "An object, or a link of it that moves, can be seen but has no `<collision>`. It passes "
        "through everything, and nothing can be placed by its bounds. Add the element, usually "
        "with the geometry of `<visual>`.",
    ),
    FILLED: (
        "Hollow mesh that collides as if it had a lid",
        "An object that moves collides by convex shapes: each group of its mesh as its convex "
        "hull. A mug of one group is filled, so nothing can be put into it, and no finger reaches "
        "inside. `taskbuilder objects import FILE` cuts a mesh into convex pieces, with the extra "
        "`import`. If the hull is meant, write `collide: hull`.",
    ),
    XACRO: (
        "Xacro cannot be expanded",
        "An argument has no value, a file that is included is missing or lies outside the import "
        "root, or an expression is wrong. Give arguments with `--arg NAME=VALUE`, and packages "
        "with `--package NAME=DIR`. Xacro files are expanded in a child process that may read "
        "files of the import root and of the packages, and nothing else.",
    ),
    AMBIGUOUS: (
        "Package found more than once",
        "A `package://NAME/…` or `$(find NAME)` could mean several folders at the same distance "
        "from the file. Say which one with `--package NAME=DIR`.",
    ),
    UNIT: (
        "Unit of a mesh unknown",
        "The file of the mesh states no unit, and its size is plausible in none or in several. "
        "Give the unit with `--unit m`, `--unit mm`, `--unit cm` or `--unit in`.",
    ),
    NOT_IMPORTED: (
        "Cannot be imported",
        "The file, or a part of it that moves, has no counterpart in taskbuilder: an archive, a "
        "floating or planar joint inside a robot, a closed loop of joints, or a format that is "
        "not read. The message says what to do instead.",
    ),
    NOT_HELD: (
        "Gripper does not hold",
        "`robots check` closes the gripper on blocks of 100 g and of three widths, 20, 50 and 85 % "
        "of its stroke, shakes the arm, and pulls. A block fell, or slips at a small load. Raise "
        "`force` of the gripper to the value in the message, or correct `closed`. A suction cup "
        "takes plates of 100 g, of one, two and four times its width.",
    ),
    UNTOUCHING: (
        "Finger without collision shape",
        "None of the links of a finger has a `<collision>`. The finger passes through everything. "
        "In `fingers`, name the links that touch objects, such as pads, or add collision shapes to "
        "the URDF; `robots import` makes them from the visual meshes. Some descriptions end in "
        "mounts for fingers that a user chooses: these need fingers.",
    ),
    STROKE: (
        "Stroke differs from the fingers",
        "The declared `stroke` differs by more than 10 % and 3 mm from the opening between the "
        "fingers. This is measured at the tcp, along its y axis, on the collision shapes of the "
        "open gripper. Write the measured value, or correct `open` or `tcp`.",
    ),
    FLYING: (
        "Gripper out of control",
        "The empty gripper was closed and opened. A joint became faster than anything real, did "
        "not come to rest, or did not arrive. Usually the damping of a joint is too large for the "
        "mass or the moment of inertia of its finger: the engine applies damping once per physics "
        "step, and a step that more than reverses the speed makes the finger fly. Lower the "
        "damping, as the message says; `robots import` does. Or raise the mass.",
    ),
    FORCE_LOST: (
        "Force of a finger is lost",
        "A finger presses with less than half of the force that follows from `force` of the "
        "gripper and from the geometry. The fingers are too light for the engine, which with "
        "strong motors is felt on narrow blocks first; a larger `<mass>` or a lower `force` helps. "
        "Or they do not meet the block with their pads.",
    ),
    TOOL_POINT: (
        "Tool centre point not between the fingers",
        "From the `tcp`, along its y axis, there must be a finger on both sides, and some room "
        "between them when the gripper is open. Otherwise grasps miss. That of a suction cup is "
        "2 mm before the end of its collision shape.",
    ),
    SAGGING: (
        "Arm cannot bear itself",
        "`robots check` moves every joint of the arm to its limits, and puts the arm into the "
        "posture in which gravity asks most of the joint. The joint sagged, or stayed far behind "
        "where it was told to be. Usually the `effort` of the joint in the URDF is less than "
        "gravity asks, or the masses beyond it are too large.",
    ),
}
