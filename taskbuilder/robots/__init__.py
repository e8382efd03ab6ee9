"""The robot library: a folder for each robot, with a robot.yaml beside its URDF.

A checkout has the folders in its top folder ``robots``; a wheel has them here.
"""

from taskbuilder._library import folder

__path__ = [str(folder("robots"))]
