"""Reading meshes and robot descriptions in pure Python, before the physics engine sees them.

PyBullet ends the process on some files and silently misreads others, so nothing is handed to it
unread: `paths` says which file a reference means and keeps it inside the folders it may come
from, `mesh` and `urdf` read the file and report all that is wrong with it, line by line, and
`codes` explains each kind of finding. Nothing here imports pybullet or numpy.
"""

from taskbuilder.assets.mesh import Mesh, read_mesh
from taskbuilder.assets.model import Urdf, UrdfJoint, UrdfLink, UrdfMimic, UrdfShape
from taskbuilder.assets.paths import AssetError, resolve
from taskbuilder.assets.urdf import read_urdf, resolved_text

__all__ = [
    "AssetError",
    "Mesh",
    "Urdf",
    "UrdfJoint",
    "UrdfLink",
    "UrdfMimic",
    "UrdfShape",
    "read_mesh",
    "read_urdf",
    "resolve",
    "resolved_text",
]
