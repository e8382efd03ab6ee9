"""Functions that take options of environments as keyword arguments."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from inspect import Parameter, signature
from typing import ParamSpec, TypeVar

from taskbuilder.env.options import FORMER, option_fields
from taskbuilder.errors import UsageError
from taskbuilder.wording import suggestion

P = ParamSpec("P")
R = TypeVar("R")


def takes_options(function: Callable[P, R]) -> Callable[P, R]:
    """Explain keyword arguments that are neither the function's own nor those of environments.

    Without it, ``evaluate(policy, seed=1)`` would be told the names of all options, of which none
    is the argument ``first_seed`` of `evaluate`.

    Raises:
        UsageError: On calls with such an argument.
    """
    parameters = signature(function).parameters.values()
    own = [each.name for each in parameters if each.kind is not Parameter.VAR_KEYWORD]

    @wraps(function)
    def checked(*args: P.args, **kwargs: P.kwargs) -> R:
        allowed = [*own, *option_fields()]
        for name in kwargs:
            if name not in allowed and name not in FORMER:
                help_ = suggestion(name, allowed, what="it has")
                raise UsageError(f'{function.__name__} has no argument "{name}"; {help_}')
        return function(*args, **kwargs)

    return checked
