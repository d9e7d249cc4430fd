"""What a function of a library looks up: a change of it is noticed without running it."""

from typing import Any


def names_in(function: Any) -> tuple[str, ...]:
    """The global names and attributes in the code of `function` and of what is defined in it."""
    names: tuple[str, ...] = function.__code__.co_names
    nested = [constant for constant in function.__code__.co_consts if hasattr(constant, "co_names")]
    return names + tuple(name for code in nested for name in code.co_names)
