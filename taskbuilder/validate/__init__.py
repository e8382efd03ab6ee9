"""The validator: checks that try to break a task, one function each, and their report.

The package can be called: ``taskbuilder.validate("handover")`` is `validate_task`.
"""

from __future__ import annotations

import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from taskbuilder.validate.runner import validate_task as validate

    __all__ = ["validate"]


class _Validator(ModuleType):
    """A package by the name of a function, as which it can be used."""

    @property
    def validate(self) -> Any:
        """The function; its module is imported when it is first used."""
        return import_module("taskbuilder.validate.runner").validate_task

    def __call__(self, *arguments: Any, **options: Any) -> Any:
        return self.validate(*arguments, **options)


sys.modules[__name__].__class__ = _Validator
