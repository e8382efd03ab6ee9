"""Trials in physics, alone: what a gripper holds, what an arm bears, how an object comes to lie."""
