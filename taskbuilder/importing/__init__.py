"""Importing robots and objects as their makers ship them.

A file of another format, or with meshes, packages and inertias that taskbuilder does not take as
they are, becomes a folder of files that it does: a URDF with OBJ meshes beside it and, for a
robot, a robot file. Every difference is a row of a table. The packages of the extra ``import`` are
needed here and nowhere else, and not for using what was imported.
"""
