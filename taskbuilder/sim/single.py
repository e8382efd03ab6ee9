"""What there is once: whatever holds a physics client."""

from __future__ import annotations

from typing import Any, NoReturn, SupportsIndex

from taskbuilder.errors import UsageError


class Single:
    """Cannot be copied or pickled: the copy would name the same client and move the original."""

    def __reduce_ex__(self, protocol: SupportsIndex) -> NoReturn:
        what = f"what holds a physics client ({type(self).__name__}) cannot be copied or pickled"
        raise UsageError(f"{what}; copy the environment, which builds another")

    def __deepcopy__(self, memo: dict[int, Any]) -> NoReturn:
        self.__reduce_ex__(4)
