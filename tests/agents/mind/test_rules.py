"""The mind without a language model, with the real tools and a body behind a gateway."""

import asyncio
from datetime import UTC, datetime

import pytest
from openrois_agents.mind.contract import Mind
from openrois_agents.mind.deeds import DEEDS
from openrois_agents.mind.requests import REQUESTS
from openrois_agents.mind.rules import RuleMind
from openrois_body.components.sensing import Sense
from openrois_body.components.system_information import SystemInformation
from openrois_body.messages import Place

from openrois.adapter import ComponentStatus, components
from tests.support.actors import Actor
from tests.support.clock import Clock
from tests.support.rule_stage import rule_stage

EVERYTHING = ("say", "gesture", "look_at", "go_to")


class Faces(Sense, components.FaceDetection):
    """Tells how many faces there are when it is subscribed to, as senses of a camera do, and when that changes."""

    def __init__(self, number: int, name: str | None = None) -> None:
        super().__init__(name)
        self.number = number
        self.activity.changed.add(lambda works: self.tell(self.number) if works and self.number else None)

    def tell(self, number: int) -> None:
        self.number = number
        self.face_detected(number, datetime.now(UTC))


def standing(x: float, y: float) -> SystemInformation:
    return SystemInformation("robot", lambda: ComponentStatus.READY, lambda: Place(x, y, 0.0))


def test_every_intent_has_a_deed() -> None:
    assert {each.intent for each in REQUESTS} == set(DEEDS)


async def test_it_is_a_mind_from_which_nothing_leaves() -> None:
    async with RuleMind() as made:
        mind: Mind = made
        assert mind.sends_to == ""
        assert not mind.needs_visitor
        mind.interrupted("Hello! How")


async def test_it_speaks_while_it_makes_a_gesture() -> None:
    actor = Actor(at_once=False)
    async with rule_stage(*actor.parts) as stage:
        answering = asyncio.create_task(stage.answer(RuleMind(), "hello"))
        await actor.gesturing.begun.wait()
        assert stage.said == ["Hello! How can I help you?"]
        actor.gesturing.may_end.set()
        await answering
        assert actor.gesturing.did == ["urn:x-rois:def:reaction:OpenRoIS::wave"]


async def test_a_gesture_is_made_or_is_refused_with_a_reason() -> None:
    actor = Actor()
    async with rule_stage(*actor.parts) as stage:
        mind = RuleMind()
        assert await stage.answer(mind, "could you please nod") == []
        assert actor.gesturing.did == ["urn:x-rois:def:reaction:OMG::1"]
        await stage.session.give_back("a test")
        assert await stage.answer(mind, "nod") == ["I cannot do that just now."]


async def test_it_goes_to_a_place() -> None:
    actor = Actor()
    async with rule_stage(*actor.parts, tools=EVERYTHING) as stage:
        assert await stage.answer(RuleMind(), "please walk to the plant") == [
            "I am going to the plant.",
            "Here is the plant.",
        ]
        assert actor.walking.did == ["plant"]
    async with rule_stage(*actor.parts) as stage:
        assert (await stage.answer(RuleMind(), "go to the plant"))[-1] == "I cannot do that with this body."


async def test_a_body_without_legs_says_so() -> None:
    actor = Actor()
    parts = [each for each in actor.parts if not isinstance(each, components.Navigation)]
    async with rule_stage(*parts) as stage:
        mind = RuleMind()
        assert await stage.answer(mind, "go to the plant") == ["I cannot go anywhere with this body."]
        assert await stage.answer(mind, "come here") == ["I cannot come to you: this body does not walk."]
        assert (await stage.answer(mind, "what can you do"))[0] == "I can talk, make gestures and look where you want."


async def test_it_comes_to_the_one_person_on_its_floor() -> None:
    actor = Actor()
    async with rule_stage(*actor.parts, standing(1.0, -2.0), tools=EVERYTHING) as stage:
        assert await stage.answer(RuleMind(), "come here") == ["I am coming.", "Here I am."]
        assert actor.walking.did == ["1,1.1,1.57"]


async def test_it_does_not_come_where_it_is_already() -> None:
    actor = Actor()
    async with rule_stage(*actor.parts, standing(1.0, 1.0), tools=EVERYTHING) as stage:
        assert await stage.answer(RuleMind(), "come closer") == ["I am with you already."]
        assert actor.walking.did == []


@pytest.mark.parametrize(
    ("names", "said"),
    [
        (("Ann", "Bob", "plant"), "I see several persons, and do not know which of them you are"),
        (("plant", "table", "?"), "I do not know where you are"),
    ],
)
async def test_it_says_why_it_cannot_come(names: tuple[str, str, str], said: str) -> None:
    actor = Actor()
    actor.surroundings.names = names
    actor.surroundings.kinds = ("person", "person", "object") if "Ann" in names else ("object",) * 3
    async with rule_stage(*actor.parts, tools=EVERYTHING) as stage:
        assert await stage.answer(RuleMind(), "come here") == [f"{said}, so I cannot come to you."]


async def test_it_comes_to_the_visitor_among_several_persons() -> None:
    actor = Actor()
    actor.surroundings.names, actor.surroundings.kinds = ("Ann", "visitor", "plant"), ("person", "person", "object")
    async with rule_stage(*actor.parts, tools=EVERYTHING) as stage:
        assert await stage.answer(RuleMind(), "come here") == ["I am coming.", "Here I am."]


async def test_what_it_sees_is_what_the_senses_of_the_body_tell() -> None:
    actor, faces = Actor(), Faces(2)
    async with rule_stage(*actor.parts, faces) as stage:
        mind = RuleMind()
        around = ["On my floor there is one person.", "Around me I know the plant."]
        assert await stage.answer(mind, "what do you see") == ["Through the camera I notice 2 faces.", *around]
        faces.tell(1)
        assert await stage.answer(mind, "who is here") == ["Through the camera I notice one face.", *around]
        # A new conversation does not remember what was seen in the last one.
        await stage.session.give_back("the conversation is over")
        mind.forget()
        faces.number = 0
        await stage.session.use_body(None, None, 0)
        assert (await stage.answer(mind, "what can you see"))[0] == "Through the camera I notice no face."


async def test_a_body_that_senses_nothing_does_not_invent() -> None:
    actor = Actor()
    parts = [each for each in actor.parts if each is not actor.surroundings]
    async with rule_stage(*parts) as stage:
        mind = RuleMind()
        assert await stage.answer(mind, "what do you see") == ["I cannot see anything with this body."]
        assert await stage.answer(mind, "where are you") == ["I do not know where I am."]
        assert await stage.answer(mind, "where can you go") == ["I know no place by its name."]


async def test_what_a_game_engine_draws_is_not_seen_through_the_camera() -> None:
    async with rule_stage(*Actor().parts, Faces(3, "scene_face_detecter")) as stage:
        assert (await stage.answer(RuleMind(), "what do you see"))[0] == "Through the camera I notice no face."


async def test_it_tells_where_it_is_and_where_things_are() -> None:
    async with rule_stage(*Actor().parts, standing(1.0, -1.0)) as stage:
        mind = RuleMind()
        assert await stage.answer(mind, "where are you") == ["I am about 3 metres from the plant."]
        assert await stage.answer(mind, "where is the plant") == ["The plant is about 3 metres away, to my left."]
        assert await stage.answer(mind, "where can you go") == ["Around me I know the plant."]
    async with rule_stage(*Actor().parts) as stage:
        assert await stage.answer(RuleMind(), "how far is the plant") == ["I do not know how far the plant is from me."]


async def test_it_looks_stops_thanks_and_says_who_it_is() -> None:
    actor = Actor()
    async with rule_stage(*actor.parts) as stage:
        mind = RuleMind()
        assert await stage.answer(mind, "look to your left") == ["I am looking there."]
        assert actor.gaze.looked == [(1.0, 0.0)]
        assert await stage.answer(mind, "stop") == ["I have stopped."]
        assert stage.used[-1] == "stop"
        assert await stage.answer(mind, "thank you") == ["You are welcome."]
        assert (await stage.answer(mind, "who are you"))[0].startswith("I am robot. A program speaks")
        assert await stage.answer(mind, "how are you") == ["Thank you for asking. I am here, and I can hear you."]
        assert await stage.answer(mind, "which gestures do you know") == ["You can say: nod your head or wave."]


async def test_it_tells_the_time() -> None:
    async with rule_stage(*Actor().parts) as stage:
        mind = RuleMind(now=lambda: datetime(2026, 11, 28, 9, 5))
        assert await stage.answer(mind, "what time is it") == ["By the clock of this machine it is 9:05."]


async def test_it_repeats_its_last_answer() -> None:
    async with rule_stage(*Actor().parts) as stage:
        mind = RuleMind()
        assert await stage.answer(mind, "say that again") == ["I have not said anything yet."]
        said = await stage.answer(mind, "who are you")
        assert await stage.answer(mind, "what did you say") == said
        assert await stage.answer(mind, "repeat that") == said


async def test_it_gives_the_body_back_when_its_farewell_was_heard() -> None:
    async with rule_stage(*Actor().parts) as stage:
        assert await stage.answer(RuleMind(), "goodbye") == ["Goodbye!"]
        assert stage.used == ["gesture", "all_said", "give_back"]
        assert stage.session.held is None


async def test_what_is_not_understood_is_said_once_and_each_time_with_other_examples() -> None:
    clock = Clock()
    async with rule_stage(*Actor().parts) as stage:
        mind = RuleMind(clock=clock)
        (first,) = await stage.answer(mind, "day said water")
        assert first == "I did not understand. You can say: hello, who are you or what can you do."
        # Noise is no conversation.
        assert await stage.answer(mind, "") == []
        clock.now = 30.0
        (second,) = await stage.answer(mind, "")
        assert second.startswith("I did not understand. You can say: what do you see")
        # Who was understood meanwhile is told again at once.
        await stage.answer(mind, "thank you")
        assert await stage.answer(mind, "house") not in ([], [first], [second])


async def test_speech_without_the_wake_word_is_for_others() -> None:
    async with rule_stage(*Actor().parts) as stage:
        mind = RuleMind("computer")
        assert await stage.answer(mind, "stop") == []
        assert await stage.answer(mind, "day said water") == []
        assert await stage.answer(mind, "") == []
        assert stage.used == []
        assert await stage.answer(mind, "computer, thank you!") == ["You are welcome."]
        assert len(await stage.answer(mind, "computer day")) == 1
