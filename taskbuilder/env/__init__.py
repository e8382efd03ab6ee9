"""Environments: any task as a multi-agent, joint or vectorised one."""
