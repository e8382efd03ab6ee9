"""Experts, which play the stages of a task file through the environment's own actions."""
