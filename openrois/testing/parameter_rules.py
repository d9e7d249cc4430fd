"""Rules of a component towards clients that read and set its parameters."""

from openrois.errors import BadParameter, RoISError, Unsupported
from openrois.testing.message_rules import UNKNOWN
from openrois.testing.samples import argument, misfit
from openrois.testing.subject import LocalSubject, Subject, require
from openrois.types.messages import Argument
from openrois.types.values import decode_value

__all__ = ["it_refuses_parameters_that_do_not_fit", "its_parameters_are_told", "what_is_set_is_told"]


async def its_parameters_are_told(subject: Subject) -> None:
    """`get_parameter` answers parameters of the profile, of their types, and all that have a default."""
    values = await subject.query("get_parameter")
    subject.require_fitting("get_parameter", values, subject.profile.parameter_profiles)
    names = {parameter.name for parameter in values}
    for profile in subject.profile.parameter_profiles:
        there = profile.name in names or not profile.default_value
        require(there, f"get_parameter does not tell {profile.name}, which has a default")


async def what_is_set_is_told(subject: Subject) -> None:
    """Whatever `set_parameter` accepts is what `get_parameter` answers from then on."""
    for profile in subject.profile.parameter_profiles:
        code = profile.data_type_ref.code
        before = await subject.parameter_values()
        # A value that any component could take, what this one is known to take, and in the end what it was.
        for value in (None, subject.parameters.get(profile.name), before.get(profile.name, "")):
            wanted = argument(profile, value)
            if not await _accepted(subject, wanted):
                continue
            answered = (await subject.parameter_values()).get(profile.name, "")
            require(
                _same(code, answered, wanted.value),
                f"set_parameter accepted {profile.name} = {wanted.value!r}, get_parameter tells {answered!r}",
            )


def _same(code: str, answered: str, given: str) -> bool:
    try:
        return answered == given or bool(decode_value(code, answered) == decode_value(code, given))
    except ValueError:
        return False


async def _accepted(subject: Subject, wanted: Argument) -> bool:
    """Set one parameter; where it is refused nothing may have changed."""
    before = await subject.parameter_values()
    doing = f"set_parameter {wanted.name} = {wanted.value!r}"
    try:
        await subject.within(doing, subject.bus.invoke(subject.component_ref, "set_parameter", (wanted,)))
    except RoISError as error:
        # Over a wire a refusal of the component itself is a command that ends with ERROR.
        known = isinstance(error, BadParameter) or not isinstance(subject, LocalSubject)
        require(known, f"{doing} is refused with {type(error).__name__}, not BadParameter: {error}")
        require(await subject.parameter_values() == before, f"{doing} was refused, and has changed something")
        return False
    return True


async def it_refuses_parameters_that_do_not_fit(subject: Subject) -> None:
    """Unknown, misfitting and repeated parameters are BadParameter, and none of those set with them is stored."""
    before = await subject.parameter_values()
    strange = Argument(name=UNKNOWN, data_type_ref="string", value="x")
    wrong: list[tuple[Argument, ...]] = [(strange,)]
    companions = [argument(profile) for profile in subject.profile.parameter_profiles]
    for profile in subject.profile.parameter_profiles:
        bad = misfit(profile.data_type_ref.code)
        others = tuple(each for each in companions if each.name != profile.name)
        wrong.append((argument(profile), argument(profile)))
        if bad is not None:
            wrong.append((*others, argument(profile, bad)))
    wrong.append((*companions, strange))
    for arguments in wrong:
        doing = f"set_parameter of {', '.join(f'{each.name} = {each.value!r}' for each in arguments)}"
        work = subject.bus.invoke(subject.component_ref, "set_parameter", arguments)
        # Without parameters there is no such command either.
        errors = (BadParameter,) if subject.profile.parameter_profiles else (BadParameter, Unsupported)
        await subject.refused(doing, work, *errors)
        require(await subject.parameter_values() == before, f"{doing} was refused, and has changed something")
