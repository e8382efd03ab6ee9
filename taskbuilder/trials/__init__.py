"""Trials of a robot in physics, alone: what its gripper holds, and what its arm bears."""
