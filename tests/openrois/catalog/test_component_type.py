"""Component types: the profile of an instance, and the definition of the type."""

from openrois.catalog.actuation import NAVIGATION
from openrois.catalog.basic import BASIC_COMPONENTS
from openrois.catalog.common import ROIS_COMMON
from openrois.catalog.component_type import CommandType, ComponentType, EventType, QueryType
from openrois.catalog.payload import Payload
from openrois.catalog.streaming import VIDEO_STREAMING
from openrois.catalog.system_information import SYSTEM_INFORMATION
from openrois.types.codes import ComponentFunction


class Glow(Payload):
    """How bright it is."""

    level: int = 3


LAMP = ComponentType(
    code="Lamp",
    name="lamp",
    description="A lamp.",
    source="this file",
    authority="Example",
    commands=(CommandType("glow", "Glow.", Glow, Glow, timeout=500),),
    queries=(QueryType("level", "Ask.", Glow),),
    events=(EventType("changed", "It changed.", Glow),),
    parameters=Glow,
    includes=(ROIS_COMMON,),
)
LANTERN = ComponentType(code="Lantern", name="lantern", description="A lamp.", source="this file", includes=(LAMP,))


def test_an_instance_lists_all_it_does_with_the_common_messages_first() -> None:
    profile = LAMP.profile("ceiling")
    assert (profile.identifier.authority, profile.identifier.code) == ("Example", "Lamp")
    assert profile.component_type == LAMP.urn == "urn:x-rois:def:component:Example::Lamp"
    assert (profile.name, profile.function, profile.sub_component_profiles) == ("ceiling", None, ())
    assert [each.name for each in profile.command_profiles] == ["start", "stop", "suspend", "resume", "glow"]
    assert [each.name for each in profile.query_profiles] == ["component_status", "level"]
    assert [each.name for each in profile.event_profiles] == ["changed"]
    assert [each.name for each in profile.parameter_profiles] == ["level"]
    glow = profile.command_profiles[-1]
    assert (glow.timeout, glow.arguments, glow.results) == (500, Glow.profiles(), Glow.profiles())


def test_a_definition_names_what_it_includes() -> None:
    profile = LAMP.definition()
    assert profile.name == "lamp"
    assert profile.sub_component_profiles == ("urn:x-rois:def:Component:OMG::RoISCommon",)
    assert [each.name for each in profile.command_profiles] == ["glow"]
    assert [each.name for each in profile.query_profiles] == ["level"]
    assert profile.event_profiles == LAMP.profile().event_profiles


def test_what_is_included_includes_too() -> None:
    assert [each.name for each in LANTERN.all_commands()] == ["start", "stop", "suspend", "resume", "glow"]
    assert [each.name for each in LANTERN.all_queries()] == ["component_status", "level"]
    assert LANTERN.all_events() == LAMP.events
    assert LANTERN.definition().sub_component_profiles == (LAMP.urn,)


def test_payloads_are_those_of_its_own_messages() -> None:
    assert list(LAMP.payloads()) == [Glow] * 5
    assert list(LANTERN.payloads()) == []
    assert len(list(VIDEO_STREAMING.payloads())) == 7


def test_what_acts_cannot_be_used_without_start_and_stop_nor_a_stream_without_its_connection() -> None:
    assert NAVIGATION.required_commands() == ("start", "stop")
    assert VIDEO_STREAMING.required_commands() == ("connect_stream", "disconnect_stream")
    assert SYSTEM_INFORMATION.required_commands() == ()


def test_only_the_system_information_lacks_the_common_messages() -> None:
    without = [kind for kind in BASIC_COMPONENTS if "start" not in {each.name for each in kind.all_commands()}]
    assert without == [SYSTEM_INFORMATION]


def test_an_instance_is_called_as_in_the_standard_unless_it_has_a_name() -> None:
    assert NAVIGATION.profile().name == "navigation"
    assert NAVIGATION.profile("legs").name == "legs"
    assert NAVIGATION.profile().function is ComponentFunction.ACTUATION
