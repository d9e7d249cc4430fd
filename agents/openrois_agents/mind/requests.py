"""What a visitor can ask of a body without a language model, in the words that visitors have for it. Pure."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final

__all__ = ["GESTURE_SENTENCES", "OTHER_WORDS", "POLITE_AFTER", "POLITE_BEFORE", "REQUESTS", "Request"]


@dataclass(frozen=True, slots=True)
class Request:
    """A request or question, and the sentences that mean it.

    Attributes:
        intent: what is meant.
        sentences: in lower case, without punctuation; `{place}` stands at the end for a place, and `{gesture}` for a
            gesture that has no sentences of its own. The first one is shown as an example.
        argument: of the intent, where no place or gesture is one.
        tool: that the body needs for it; empty where every body can do it.
        is_request: whether "please" goes with it.
    """

    intent: str
    sentences: tuple[str, ...]
    argument: str = ""
    tool: str = ""
    is_request: bool = False


def _looking(direction: str, *sentences: str) -> Request:
    return Request("look_at", sentences, direction, "look_at", is_request=True)


REQUESTS: Final = (
    Request("greet", ("hello", "good morning", "good afternoon", "good evening")),
    Request(
        "who", ("who are you", "what is your name", "what are you", "introduce yourself", "tell me about yourself")
    ),
    Request("can", ("what can you do", "what can i say", "what can i ask you", "help me", "i need help")),
    Request(
        "see",
        (
            "what do you see",
            "what can you see",
            "who do you see",
            "who can you see",
            "who is here",
            "what is around you",
        ),
    ),
    Request("where", ("where are you", "where are you now", "where do you stand")),
    Request("time", ("what time is it", "what is the time", "tell me the time")),
    Request(
        "how", ("how are you", "how are you today", "hello how are you", "hello how are you today", "how do you do")
    ),
    Request(
        "go_to",
        (
            *("go to the {place}", "walk to the {place}", "move to the {place}", "go over to the {place}"),
            *("drive to the {place}", "go to {place}", "take me to the {place}", "bring me to the {place}"),
        ),
        tool="go_to",
        is_request=True,
    ),
    Request("find", ("where is the {place}", "where can i find the {place}", "how far is the {place}")),
    Request("places", ("where can you go", "which places do you know"), tool="go_to"),
    Request("come", ("come here", "come to me", "come over here", "come closer"), tool="go_to", is_request=True),
    Request(
        "gesture", ("do the {gesture}", "show me the {gesture}", "make the {gesture}"), tool="gesture", is_request=True
    ),
    Request("gestures", ("which gestures do you know", "what gestures can you do"), tool="gesture"),
    _looking("ahead", "look at me", "look here", "look straight ahead"),
    _looking("left", "look left", "look to the left", "look to your left"),
    _looking("right", "look right", "look to the right", "look to your right"),
    _looking("up", "look up"),
    _looking("down", "look down"),
    Request("stop", ("stop", "stop it", "stop that", "stop now", "stop moving", "stop talking", "be quiet")),
    Request("repeat", ("say that again", "repeat that", "can you repeat that", "what did you say")),
    Request("thank", ("thank you", "thank you very much", "thanks a lot", "many thanks")),
    Request("leave", ("goodbye", "bye bye", "see you later", "good night")),
)
"""In the order in which they are shown as examples."""

POLITE_BEFORE: Final = ("please", "can you", "can you please", "could you", "could you please", "would you please")
POLITE_AFTER: Final = ("please", "now")
"""What may stand around a request."""

GESTURE_SENTENCES: Final[Mapping[str, tuple[str, ...]]] = MappingProxyType(
    {
        "bow": ("bow", "take a bow", "bow to me"),
        "clap": ("clap", "clap your hands"),
        "glance_at_watch": ("look at your watch", "glance at your watch", "check your watch"),
        "goto_sleep": ("go to sleep",),
        "greet": ("greet me", "give me a greeting"),
        "happy": ("be happy", "look happy"),
        "listen": ("listen to me",),
        "look_around": ("look around", "take a look around"),
        "nod": ("nod your head", "nod", "give me a nod"),
        "raise_hand": ("raise your hand", "raise a hand"),
        "sad": ("be sad", "look sad"),
        "shake_hands": ("shake hands", "shake my hand", "give me your hand"),
        "shake_head": ("shake your head",),
        "shrug": ("shrug your shoulders", "shrug"),
        "surprise": ("be surprised", "look surprised"),
        "surprised": ("be surprised", "look surprised"),
        "think": ("think about it",),
        "tilt": ("tilt your head",),
        "wake_up": ("wake up",),
        "wave": ("wave", "wave your hand", "wave to me", "give me a wave"),
    }
)
"""Sentences for gestures by the names that bodies of OpenRoIS and the standard give them."""

OTHER_WORDS: Final = (
    *("back", "been", "came", "day", "did", "from", "get", "great", "had", "house", "little", "long", "made", "number"),
    *("old", "only", "part", "people", "please", "said", "small", "some", "think", "three", "time", "water", "with"),
)
"""Words for speech that is none of the above: common ones that are unlike it, and what such speech shares with it."""
