"""Robots that people steer: who steers which, what they command, and the episodes of it."""

from __future__ import annotations
