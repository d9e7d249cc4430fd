"""What a mind without a language model does for each intent, by the tools of the body that it has."""

from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass, field
from datetime import datetime
from types import MappingProxyType
from typing import Any, Final

from openrois_agents.mind import replies
from openrois_agents.mind.contract import Stage
from openrois_agents.mind.phrases import Phrases
from openrois_agents.mind.placing import Place, before_person, place_of, places_by_name
from openrois_agents.tools.answer import Answer

__all__ = ["DEEDS", "Acting", "Memory"]

_GREETINGS: Final = ("wave", "greet", "nod")
"""Gestures that go with a greeting, the first one that a body has."""
_NAMED: Final = 6
_SENSED: Final = (("face_detected", "face"), ("person_detected", "person"))
"""Events of senses of a camera, the more telling first, and what they count."""
_SENSING: Final = 1.5
"""Seconds within which a sense tells what there is: longer than from one look at a picture to the next."""
_SCENE: Final = "scene"
"""In the name of a component: it senses no camera, but what a game engine draws."""
_VISITOR: Final = "visitor"
"""The name of the person on a floor who stands for the one who speaks."""


@dataclass(slots=True)
class Memory:
    """What is remembered of a conversation.

    Attributes:
        said: the sentences of the last answer.
        since: the number of the last event before the senses were asked first; None until then.
    """

    said: list[str] = field(default_factory=list)
    since: int | None = None


@dataclass(frozen=True, slots=True)
class Acting:
    """One answer.

    Attributes:
        stage: the body.
        phrases: what can be said.
        memory: of the conversation.
        now: the time of day here.
    """

    stage: Stage
    phrases: Phrases
    memory: Memory
    now: Callable[[], datetime] = datetime.now

    async def say(self, *sentences: str) -> None:
        """Say sentences, and remember them."""
        for each in sentences:
            self.memory.said.append(each)
            await self.stage.say(each)

    async def use(self, tool: str, /, **arguments: Any) -> Answer:
        """Use a tool."""
        return await self.stage.use(tool, arguments)

    async def tools(self) -> frozenset[str]:
        """Return which tools the body has components for."""
        answer = await self.use("bodies")
        mine = [each for each in answer.data.get("bodies", ()) if each["state"] == "yours"]
        return frozenset(tool for each in mine for tool in each["tools"])

    async def gesture(self, *names: str) -> None:
        """Make the first one of these gestures that bodies have, if any; that this body has it not is no mistake."""
        known = (await self.stage.vocabulary()).gestures
        if name := next((each for each in names if each in known), ""):
            await self.use("gesture", name=name)

    async def require(self, tool: str, without: str) -> bool:
        """Return whether the body has a tool; where not, say so."""
        if tool in await self.tools():
            return True
        await self.say(without)
        return False


Deed = Callable[[Acting, str], Awaitable[None]]


async def _greet(acting: Acting, _argument: str) -> None:
    await acting.say("Hello! How can I help you?")
    await acting.gesture(*_GREETINGS)


async def _leave(acting: Acting, _argument: str) -> None:
    await acting.say("Goodbye!")
    await acting.gesture(*_GREETINGS)
    await acting.stage.all_said()
    await acting.use("give_back")


async def _who(acting: Acting, _argument: str) -> None:
    answer = await acting.use("bodies")
    names = [each["body"] for each in answer.data.get("bodies", ()) if each["state"] == "yours"]
    name = f"I am {names[0]}. " if names else ""
    await acting.say(f"{name}A program speaks and moves through this body.", "It understands some sentences, by rules.")


async def _can(acting: Acting, _argument: str) -> None:
    await acting.say(replies.ability(await acting.tools()))
    await acting.say(f"You can say, for example: {replies.listed(acting.phrases.examples[1:_NAMED], 'or')}.")


async def _gestures(acting: Acting, _argument: str) -> None:
    names = [said for said, each in acting.phrases.meanings.items() if each.name == "gesture"]
    first = {acting.phrases.meanings[said].argument: said for said in reversed(names)}
    await acting.say(
        f"You can say: {replies.listed(sorted(first.values())[:_NAMED], 'or')}." if names else "I know none."
    )


async def _places(acting: Acting, _argument: str) -> None:
    places, _, at = await _where(acting)
    told = replies.around(places, {}, at)
    await acting.say(*told or ("I know no place by its name.",))


async def _how(acting: Acting, _argument: str) -> None:
    await acting.say("Thank you for asking. I am here, and I can hear you.")


async def _time(acting: Acting, _argument: str) -> None:
    now = acting.now()
    await acting.say(f"By the clock of this machine it is {now.hour}:{now.minute:02d}.")


async def _thank(acting: Acting, _argument: str) -> None:
    await acting.say("You are welcome.")


async def _gesture(acting: Acting, name: str) -> None:
    answer = await acting.use("gesture", name=name)
    if replies.failed(answer):
        await acting.say(replies.refusal(answer))


async def _look_at(acting: Acting, direction: str) -> None:
    answer = await acting.use("look_at", direction=direction)
    await acting.say(replies.refusal(answer) if replies.failed(answer) else "I am looking there.")


async def _stop(acting: Acting, _argument: str) -> None:
    answer = await acting.use("stop")
    await acting.say("I could not stop everything." if replies.failed(answer) else "I have stopped.")


async def _repeat(acting: Acting, _argument: str) -> None:
    said, acting.memory.said = acting.memory.said, []
    await acting.say(*said or ("I have not said anything yet.",))


async def _go_to(acting: Acting, place: str) -> None:
    if await acting.require("go_to", "I cannot go anywhere with this body."):
        await acting.say(f"I am going to the {place}.")
        answer = await acting.use("go_to", place=place)
        await acting.say(replies.refusal(answer) if replies.failed(answer) else f"Here is the {place}.")


async def _come(acting: Acting, _argument: str) -> None:
    if not await acting.require("go_to", "I cannot come to you: this body does not walk."):
        return
    _, persons, at = await _where(acting)
    person = persons.get(_VISITOR) or (next(iter(persons.values())) if len(persons) == 1 else None)
    if person is None:
        why = (
            "I see several persons, and do not know which of them you are" if persons else "I do not know where you are"
        )
        await acting.say(f"{why}, so I cannot come to you.")
        return
    target = before_person(person, at)
    if target is None:
        await acting.say("I am with you already.")
        return
    await acting.say("I am coming.")
    answer = await acting.use("go_to", x=round(target.x, 2), y=round(target.y, 2), facing=round(target.th, 2))
    await acting.say(replies.refusal(answer) if replies.failed(answer) else "Here I am.")


async def _where_are_you(acting: Acting, _argument: str) -> None:
    places, _, at = await _where(acting)
    if at is None or not places:
        await acting.say("I do not know where I am.")
        return
    nearest = min(places, key=lambda name: places[name].distance(at))
    metres = replies.number_of(max(1, round(places[nearest].distance(at))), "metre")
    await acting.say(f"I am about {metres} from the {nearest}.")


async def _find(acting: Acting, name: str) -> None:
    places, _, at = await _where(acting)
    if name in places and at is not None:
        await acting.say(replies.distance(name, places[name], at))
    else:
        await acting.say(f"I do not know how far the {name} is from me.")


async def _see(acting: Acting, _argument: str) -> None:
    places, persons, at = await _where(acting)
    told = [*await _sensed(acting), *replies.around(places, persons, at)]
    await acting.say(*told or ("I cannot see anything with this body.",))


async def _where(acting: Acting) -> tuple[dict[str, Place], dict[str, Place], Place | None]:
    """Return the places and persons that the body knows by name, and where it is itself."""
    told = (await acting.use("where")).data
    position = told.get("position")
    first = next(iter(position.get("position_data", ())), "") if isinstance(position, Mapping) else ""
    return places_by_name(told.get("places")), places_by_name(told.get("persons")), place_of(first)


async def _sensed(acting: Acting) -> list[str]:
    """Return what the senses of a camera tell: how many faces, or else persons."""
    memory = acting.memory
    if memory.since is None:
        memory.since = (await acting.use("wait_for_event", seconds=0)).data.get("last", 0)
    for event, noun in _SENSED:
        answer = await acting.use("wait_for_event", events=[event], seconds=_SENSING, after=memory.since)
        if not replies.failed(answer):
            told = [each for each in answer.data.get("events", ()) if _SCENE not in each["source"]]
            return [replies.faces(told[-1]["data"].get("number", 0) if told else 0, noun)]
    return []


DEEDS: Final[Mapping[str, Deed]] = MappingProxyType(
    {
        "greet": _greet,
        "who": _who,
        "can": _can,
        "see": _see,
        "where": _where_are_you,
        "how": _how,
        "time": _time,
        "go_to": _go_to,
        "find": _find,
        "places": _places,
        "come": _come,
        "gesture": _gesture,
        "gestures": _gestures,
        "look_at": _look_at,
        "stop": _stop,
        "repeat": _repeat,
        "thank": _thank,
        "leave": _leave,
    }
)
"""By the name of the intent."""
