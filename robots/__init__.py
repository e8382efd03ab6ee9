"""The robot library: a folder for each robot, with a robot.yaml beside its URDF."""

if __name__ != "taskbuilder.robots":
    # Two import paths would make two unequal copies of one robot.
    raise ImportError(f"import this package as taskbuilder.robots, not as {__name__}")
