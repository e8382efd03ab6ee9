"""Kinematics of arms, in plain numbers: no physics engine is needed.

`chain` has the joints between base and tool, `inverse` searches for joint positions that bring the
tool to a pose, and `differential_ik` takes one step of a control loop towards a pose.

Importing this package loads nothing; import the module that is needed.
"""
