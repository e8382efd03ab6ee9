"""The physics layer: bodies, joints, contacts, pictures and snapshots of one Bullet client.

The only layer that knows the physics engine. It knows nothing of tasks, agents or files other
than the meshes and URDFs it is handed. Every object belongs to one `client.Client`; there is no
global state, so any number of clients live side by side in a process.

Conventions: metres, kilograms, seconds, newtons and radians; poses are `geometry.Pose`;
quaternions are x, y, z, w. A body's pose is that of its own frame, the one its parts or its URDF
are written in, never that of its centre of mass.

Importing this package loads nothing; import the module that is needed.
"""
