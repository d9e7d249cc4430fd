"""Arguments and parameters of the wire against the profile that they are meant for."""

from openrois.errors import BadParameter
from openrois.types.messages import Argument
from openrois.types.profiles import ParameterProfile
from openrois.types.values import check_value

__all__ = ["check_arguments"]


def check_arguments(profiles: tuple[ParameterProfile, ...], arguments: tuple[Argument, ...]) -> dict[str, str]:
    """Return the arguments' values by name; each keeps the type of the profile, whatever type the client wrote.

    Raises:
        BadParameter: a name is unknown or repeated, or a value does not fit.
    """
    types = {profile.name: profile.data_type_ref.code for profile in profiles}
    values: dict[str, str] = {}
    for argument in arguments:
        if argument.name not in types:
            raise BadParameter(f"nothing here is called {argument.name!r}; there are: {', '.join(types) or 'none'}")
        if argument.name in values:
            raise BadParameter(f"{argument.name!r} is given twice")
        try:
            check_value(types[argument.name], argument.value)
        except ValueError as error:
            raise BadParameter(f"{argument.name}: {error}") from None
        values[argument.name] = argument.value
    return values
