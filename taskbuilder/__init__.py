"""Author, prove and render multi-robot manipulation tasks on PyBullet."""

from taskbuilder._version import __version__

__all__ = ["__version__"]
