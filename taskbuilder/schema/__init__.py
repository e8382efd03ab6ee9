"""Typed models of task and robot files, read with line marks, and the catalogue of both.

Nothing here imports pybullet: a file can be checked without a physics engine.
"""
