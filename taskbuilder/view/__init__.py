"""A live page in the browser: the scene, episodes of any policy, and the findings on a task."""

from __future__ import annotations
