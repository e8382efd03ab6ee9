"""The task library: NAME.yaml (the scene) beside NAME.py (its description).

A checkout has the files in its top folder ``tasks``; a wheel has them here.
"""

from taskbuilder._library import folder

__path__ = [str(folder("tasks"))]
