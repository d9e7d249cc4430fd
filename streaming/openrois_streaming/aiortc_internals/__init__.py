"""All uses of private names of aiortc and aioice. `trial.self_test` checks that these still hold.

* `connection`: how the sections of a peer connection are started, and what was negotiated.
* `incoming`: checks of arriving packets.
* `channels`: checks of arriving data channel messages.
* `sending`, `srtp`: our sender in place of aiortc's.
* `receiving`: our receiver in place of aiortc's.
* `ice`, `ice_checks`: the agent with its guard, and its connectivity checks.

`names_in` lists the names that a library function looks up, so that a change is noticed without running it.
"""

from typing import Any


def names_in(function: Any) -> tuple[str, ...]:
    """Return the global names and attributes in the code of `function` and of its nested functions."""
    names: tuple[str, ...] = function.__code__.co_names
    nested = [constant for constant in function.__code__.co_consts if hasattr(constant, "co_names")]
    return names + tuple(name for code in nested for name in code.co_names)
