"""The decorators of component authors: which methods are messages, and what their profile says beside the signature."""

from collections.abc import Callable, Coroutine
from dataclasses import dataclass, replace
from functools import wraps
from inspect import iscoroutinefunction
from typing import Any, Final, Literal, TypeVar, cast, overload

__all__ = ["Mark", "command", "event", "mark_of", "optional", "query"]

_Async = TypeVar("_Async", bound=Callable[..., Coroutine[Any, Any, Any]])
_Sync = TypeVar("_Sync", bound=Callable[..., None])
_Any = TypeVar("_Any", bound=Callable[..., Any])

_ATTRIBUTE: Final = "__rois_mark__"
_SECOND: Final = 1000


@dataclass(frozen=True, slots=True)
class Mark:
    """Declaration of a method by a decorator.

    Attributes:
        kind: of message.
        name: on the wire; empty for the method's own.
        result: the name of the only result; empty for the message's.
        timeout: the milliseconds a command may take; None for as long as it likes.
        optional: it stands for a message of the type that nothing implements yet.
    """

    kind: Literal["command", "query", "event"]
    name: str = ""
    result: str = ""
    timeout: int | None = None
    optional: bool = False


def mark_of(function: Any) -> Mark | None:
    """Return what a decorator declared of a method, or None."""
    mark: Mark | None = getattr(function, _ATTRIBUTE, None)
    return mark


@overload
def command(function: _Async, /) -> _Async: ...
@overload
def command(*, name: str = "", result: str = "", timeout: float | None = None) -> Callable[[_Async], _Async]: ...
def command(
    function: _Async | None = None, /, *, name: str = "", result: str = "", timeout: float | None = None
) -> _Async | Callable[[_Async], _Async]:
    """Mark an async method as a command: its parameters are the arguments, what it returns are the results.

    Args:
        function: the method, where the decorator stands without parentheses.
        name: of the command on the wire; the method's unless given.
        result: the name of the result where the method returns a single value; the command's unless given.
        timeout: seconds after which the command is cancelled and ends with TIMEOUT.

    Raises:
        TypeError: it is not async, or `timeout` is not positive.
    """
    if timeout is not None and timeout * _SECOND < 1:
        raise TypeError(f"a timeout of {timeout} s leaves no time; write None for as long as it takes")
    mark = Mark("command", name, result, None if timeout is None else round(timeout * _SECOND))
    return _marking(mark) if function is None else _marking(mark)(function)


@overload
def query(function: _Async, /) -> _Async: ...
@overload
def query(*, name: str = "", result: str = "") -> Callable[[_Async], _Async]: ...
def query(
    function: _Async | None = None, /, *, name: str = "", result: str = ""
) -> _Async | Callable[[_Async], _Async]:
    """Mark an async method without parameters as a query: what it returns are the results.

    Args:
        function: the method, where the decorator stands without parentheses.
        name: of the query on the wire; the method's unless given.
        result: the name of the result where the method returns a single value; the query's unless given.

    Raises:
        TypeError: it is not async.
    """
    mark = Mark("query", name, result)
    return _marking(mark) if function is None else _marking(mark)(function)


def _marking(mark: Mark) -> Callable[[_Async], _Async]:
    def decorate(function: _Async) -> _Async:
        if not iscoroutinefunction(function):
            name = getattr(function, "__qualname__", repr(function))
            raise TypeError(
                f"{name} is a {mark.kind}: write `async def`, and `await asyncio.to_thread(...)` for what blocks"
            )
        setattr(function, _ATTRIBUTE, mark)
        return function

    return decorate


@overload
def event(function: _Sync, /) -> _Sync: ...
@overload
def event(*, name: str = "") -> Callable[[_Sync], _Sync]: ...
def event(function: _Sync | None = None, /, *, name: str = "") -> _Sync | Callable[[_Sync], _Sync]:
    """Make a method an event: its parameters are the results, its body stays empty, and calling it announces the event.

    It may be called from any thread. A parameter that is None is left out; a moment (`datetime`) that the component's
    type asks for is then now.

    Args:
        function: the method, where the decorator stands without parentheses.
        name: of the event on the wire; the method's unless given.

    Raises:
        TypeError: it is async; when called: the arguments are not those of the method.
        ValueError: when called: a value is not of its type.
    """

    def decorate(function: _Sync) -> _Sync:
        if iscoroutinefunction(function):
            raise TypeError(f"{function.__qualname__} is an event: write `def`, announcing one does not wait")

        @wraps(function)
        def announce(self: Any, /, *values: Any, **named: Any) -> None:
            self.__rois_announce__(function.__name__, values, named)

        setattr(announce, _ATTRIBUTE, Mark("event", name))
        return cast(_Sync, announce)

    return decorate if function is None else decorate(function)


def optional(function: _Any) -> _Any:
    """Make a decorated message one that a subclass may implement: until then it is in no profile.

    Args:
        function: a method that `command` or `query` has marked already: `@optional` stands above them.

    Raises:
        TypeError: it is no message.
    """
    mark = mark_of(function)
    if mark is None:
        raise TypeError(f"{function.__qualname__} is no message: write `@command` or `@query` below `@optional`")
    setattr(function, _ATTRIBUTE, replace(mark, optional=True))
    return function
