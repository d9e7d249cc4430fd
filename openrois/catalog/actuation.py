"""The basic components that act (11 to 15): speech, reactions and motion."""

from typing import Annotated, Final

from openrois.catalog.common import ROIS_COMMON
from openrois.catalog.component_type import ComponentType, EventType, QueryType
from openrois.catalog.payload import Data, Payload
from openrois.types.codes import ComponentFunction

__all__ = [
    "FOLLOW",
    "MOVE",
    "NAVIGATION",
    "REACTION",
    "SPEECH_SYNTHESIS",
    "AvailableReactionsResult",
    "AvailableVoicesResult",
    "FollowParameters",
    "MoveParameters",
    "NavigationParameters",
    "ReachedTarget",
    "ReactionParameters",
    "SpeechSynthesisParameters",
    "SynthesizableLanguagesResult",
]


class SynthesizableLanguagesResult(Payload):
    """The languages that can be spoken."""

    languages: Annotated[tuple[str, ...], Data("string[]", "M", "ISO 639-1 codes", note="a parameter in the IDL")]


class AvailableVoicesResult(Payload):
    """The voices that can speak."""

    characters: Annotated[
        tuple[str, ...],
        Data("string[]", "M", "names of voices", note="the parameter synthesizable_characters in the IDL"),
    ]


class SpeechSynthesisParameters(Payload):
    """What to say and how: plain text or SSML, one of the two."""

    speech_text: Annotated[str | None, Data("string", "C", "the text to speak")] = None
    ssml_text: Annotated[
        str | None, Data("string", "C", "the SSML to speak; unknown tags are skipped", note="SSML_text in the IDL")
    ] = None
    volume: Annotated[int, Data("int", "O", "how loud, 0 to 100")] = 50
    language: Annotated[str, Data("string", "O", "ISO 639-1 code")] = "en"
    character: Annotated[
        str, Data("string", "O", "the voice's name, as in available_voices", note="RoIS_Identifier in the IDL")
    ] = "default"


class AvailableReactionsResult(Payload):
    """The reactions that can be played."""

    available_reactions: Annotated[tuple[str, ...], Data("RoISIdentifier[]", "M", "refs of reactions")]


class ReactionParameters(Payload):
    """Which reaction to play."""

    reaction_ref: Annotated[
        str | None, Data("RoISIdentifier", "M", "the reaction to play", note="a list in the IDL")
    ] = None


class ReachedTarget(Payload):
    """A position of the route was reached."""

    target: Annotated[str, Data("string", "M", "the position", note="only in the XML")]
    is_final_target: Annotated[bool, Data("bool", "M", "whether it is the last one", note="only in the XML")]


class NavigationParameters(Payload):
    """Where to go, and how."""

    target_positions: Annotated[
        tuple[str, ...] | None,
        Data(
            "string[]",
            "M",
            "the positions to pass, the last one is the destination",
            note="target_position in IDL and text",
        ),
    ] = None
    time_limit: Annotated[int, Data("int", "O", "the milliseconds it may take; 0 is no limit")] = 0
    routing_policy: Annotated[str, Data("string", "O", "what counts more: time or distance")] = "time"


class FollowParameters(Payload):
    """Whom to follow, and how closely."""

    target_object_ref: Annotated[str | None, Data("RoISIdentifier", "M", "whom or what to follow")] = None
    distance: Annotated[int | None, Data("int", "M", "the millimetres to stay behind")] = None
    time_limit: Annotated[int | None, Data("int", "O", "the milliseconds to follow for at most")] = None


class MoveParameters(Payload):
    """A motion: along a line or a curve, one of the two."""

    line: Annotated[tuple[int, ...] | None, Data("int[]", "C", "the millimetres to go and the degrees to turn")] = None
    curve: Annotated[
        tuple[int, ...] | None, Data("int[]", "C", "the curve's radius in millimetres and its direction in degrees")
    ] = None
    time: Annotated[int | None, Data("int", "O", "the milliseconds it should take")] = None


SPEECH_SYNTHESIS: Final = ComponentType(
    code="SpeechSynthesis",
    name="speech_synthesizer",
    description="Speaks a text; `start` is completed when it has been spoken.",
    source="SpeechSynthesis.xml",
    function=ComponentFunction.ACTUATION,
    part="voice",
    queries=(
        QueryType("synthesizable_languages", "Ask which languages it speaks.", SynthesizableLanguagesResult),
        QueryType("available_voices", "Ask which voices it has.", AvailableVoicesResult),
    ),
    parameters=SpeechSynthesisParameters,
    includes=(ROIS_COMMON,),
)

REACTION: Final = ComponentType(
    code="Reaction",
    name="reaction",
    description="Plays a reaction, such as a nod.",
    source="Reaction.xml",
    function=ComponentFunction.ACTUATION,
    part="gesture",
    queries=(QueryType("available_reactions", "Ask which reactions it can play.", AvailableReactionsResult),),
    parameters=ReactionParameters,
    includes=(ROIS_COMMON,),
)

NAVIGATION: Final = ComponentType(
    code="Navigation",
    name="navigation",
    description="Goes to a place; `start` is completed at the last position.",
    source="Navigation.xml",
    function=ComponentFunction.ACTUATION,
    part="legs",
    events=(EventType("reached_target", "A position of the route was reached.", ReachedTarget),),
    parameters=NavigationParameters,
    includes=(ROIS_COMMON,),
)

FOLLOW: Final = ComponentType(
    code="Follow",
    name="follower",
    description="Follows a person or thing until it is stopped.",
    source="Follow.xml",
    function=ComponentFunction.ACTUATION,
    part="legs",
    parameters=FollowParameters,
    includes=(ROIS_COMMON,),
)

MOVE: Final = ComponentType(
    code="Move",
    name="move",
    description="Makes a motion; `start` is completed at its end.",
    source="Move.xml",
    function=ComponentFunction.ACTUATION,
    part="legs",
    parameters=MoveParameters,
    includes=(ROIS_COMMON,),
)
