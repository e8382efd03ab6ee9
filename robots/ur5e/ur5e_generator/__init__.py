"""What generate.py draws the UR5e from: each module a step from the figures to the files.

``generate.py`` puts its own folder on the import path, so this package goes by a name that no other
robot's has; it is not a part of the robot library.
"""
