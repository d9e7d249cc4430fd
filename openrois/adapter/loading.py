"""Components that are named on a command line, `package:Class`, and added to those of a body."""

import argparse
import inspect
from collections.abc import Callable, Iterable, Sequence
from importlib import import_module

from openrois.component.component import Component
from openrois.errors import BadParameter

__all__ = ["add_component_option", "component_arguments", "load_components", "make_components"]

_SEPARATOR = ":"
_BODY = "body"


def add_component_option(parser: argparse.ArgumentParser) -> None:
    """Add `--component`; `load_components` reads it."""
    parser.add_argument(
        "--component",
        action="append",
        default=[],
        dest="own_components",
        metavar="PACKAGE:CLASS",
        help="add a component of your own; given again for each one",
    )


def component_arguments(chosen: argparse.Namespace) -> Sequence[str]:
    """Return the options as they were given, for another command line."""
    return [part for name in chosen.own_components for part in ("--component", name)]


def load_components(names: Iterable[str]) -> tuple[type[Component], ...]:
    """Return the classes of the names.

    Raises:
        ValueError: a name is no `package:Class`, or there is no such component; a sentence for a person.
    """
    return tuple(map(_load, names))


def make_components(
    classes: Sequence[type[Component]], body: object, others: Iterable[Component]
) -> tuple[Component, ...]:
    """Return an instance of each class; a class whose constructor has a parameter `body` gets the body.

    Args:
        classes: of the components.
        body: that they are added to.
        others: the components that it has already.

    Raises:
        BadParameter: a component cannot be made, or has the name of another one; a sentence for a person.
    """
    made: list[Component] = []
    taken = {other.name: "of the body" for other in others}
    for each in classes:
        named = f"--component {each.__module__}{_SEPARATOR}{each.__qualname__}"
        component = _make(each, body, named)
        if component.name in taken:
            raise BadParameter(
                f"{named}: its name {component.name!r} is that of a component {taken[component.name]}; let its"
                " constructor give super().__init__ another name"
            )
        taken[component.name] = f"of {named}"
        made.append(component)
    return tuple(made)


def _load(name: str) -> type[Component]:
    module_name, separator, class_name = name.partition(_SEPARATOR)
    if not (separator and module_name and class_name):
        raise ValueError(f"--component {name}: write PACKAGE:CLASS, as my_components.greeter:Greeter")
    try:
        module = import_module(module_name)
    except ModuleNotFoundError as error:
        if error.name is None or not f"{module_name}.".startswith(f"{error.name}."):
            raise ValueError(f"--component {name}: {module_name} needs {error.name}, which is not installed") from error
        raise ValueError(
            f"--component {name}: there is no module {error.name}; install it, or name its folder in PYTHONPATH"
        ) from None
    except Exception as error:  # whatever a module of a user raises when it is read
        raise ValueError(f"--component {name}: {module_name} cannot be imported: {error!r}") from error
    found = getattr(module, class_name, None)
    if found is None:
        raise ValueError(f"--component {name}: {module_name} has no {class_name}")
    if not (isinstance(found, type) and issubclass(found, Component)) or found is Component:
        raise ValueError(
            f"--component {name}: {class_name} is no component: it has to extend openrois.adapter.Component"
        )
    return found


def _make(each: type[Component], body: object, named: str) -> Component:
    constructor: Callable[..., Component] = each
    try:
        parameters = inspect.signature(each.__init__).parameters
        return constructor(**{_BODY: body}) if _BODY in parameters else constructor()
    except Exception as error:  # whatever a constructor of a user raises
        raise BadParameter(f"{named} cannot be made: {error or repr(error)}") from error
