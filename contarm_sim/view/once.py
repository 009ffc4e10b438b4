"""What several figures, or one at several widths, are drawn from is computed once."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any, TypeVar

_Computed = TypeVar("_Computed", bound=Callable[..., Any])


def once(function: _Computed) -> _Computed:
    """Keep the last few results of a function: nobody may change them."""
    return lru_cache(maxsize=8)(function)  # type: ignore[return-value]
