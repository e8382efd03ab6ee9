"""The task library: NAME.yaml (the scene) beside NAME.py (its description)."""

if __name__ != "taskbuilder.tasks":
    # Two import paths would make two unequal classes of one description.
    raise ImportError(f"import this package as taskbuilder.tasks, not as {__name__}")
