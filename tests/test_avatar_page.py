"""Pages on the avatar, its engines and its speed: the numbers that stand there are those that the avatar goes by."""

import math
from pathlib import Path

import pytest
from openrois_avatar.engines import size_choice
from openrois_avatar.engines.room import life, shot, visitor, walking
from openrois_avatar.link import connection, embedded, external, picture_source, reconnecting, server
from openrois_avatar.link.messages import greeting
from openrois_body import body
from openrois_body.components import follow, navigation
from openrois_body.hearing import ear, noise_floor, voice_activity
from openrois_body.messages import gestures, motion, reading
from openrois_body.motion import ground, legs, moves, planning, targets, wayfinding
from openrois_body.processes import child
from openrois_body.sound import engine_sound
from openrois_body.speech import markup, playout_delay
from openrois_body.teleoperation import pilot
from openrois_body.vision import box, head_gestures, tracks, watch
from openrois_media import devices
from openrois_streaming.source.supervision import HUNG

DOCS = Path(__file__).parents[1] / "docs"


def text_of(page: str) -> str:
    """The text of a page as it is read, not as it is broken into lines."""
    return " ".join((DOCS / page).read_text(encoding="utf-8").split())


AVATAR = (
    f"{playout_delay.DEVICE * 1000:g} ms are counted for encoder, decoder and mixer",
    f"{playout_delay.PLAYOUT} s are counted and three times the jitter",
    f"the last one counts, up to {playout_delay.LONGEST:g} s",
    f"At most {markup.MAX_TEXT:,} characters",
    f"no person is there after {watch.BLIND:g} s",
    f"who is away for more than {tracks.PERSON_MEMORY:g} s comes back",
    f"shows {math.degrees(box.FIELD_OF_VIEW):.0f} degrees on its longer side, a face of {box.FACE_WIDTH} m",
    f"each faster than {head_gestures._SLOWEST} s; a tilt is {math.degrees(head_gestures._TILTED):.0f} degrees",
    f"held for {head_gestures._HELD} s",
    f"the quietest moment of the last {noise_floor.MEMORY:g} s",
    f"counts as over after {voice_activity.END_SILENCE} s of silence",
    f"speaks for more than {voice_activity.LONGEST:g} s is heard in pieces",
    f"no message comes for {pilot.PATIENCE} s while something is held",
    f"a disc with a radius of {wayfinding.BODY} m, and walks {planning.SPEED:g} m/s where nothing else is said",
    f"1 to {targets.MAX_TARGETS} targets",
    f"is reached {navigation._NEAR} m from it",
    f"Ways keep {wayfinding.BODY} m from every edge",
    f"at most {math.degrees(ground._ARC):.0f} degrees of turn apart",
    f"more than {planning._MOST_STEPS:,} steps",
    f"more than {legs.TOP_SPEED:g} m/s or less than {moves._SLOWEST:g} m/s, more than {moves._MOST_DEGREES:,} degrees",
    f"from a person {follow._APART * 1000:g} at least",
    f"round all obstacles and at {follow._SPEED} m/s",
    f"when that has moved by {follow._MOVED * 100:g} cm",
    f"it stands; after {follow._GONE:g} s of that",
    f"It takes speed at {walking._GAINING} m/s², goes at most {walking.FASTEST} m/s",
    f"turns at most {walking.QUICKEST:g} rad/s",
    f"Less than {walking._ASIDE} m from a point with a direction",
    f"sideways or backwards, at {walking._SMALL} m/s",
    f"`drive` holds for {walking.HOLD} s",
    f"stops {walking.RADIUS} m before walls and furniture",
    f"and {walking.APART} m before the visitor",
    f"encodes {size_choice.PICTURES} pictures of 1280x720 when it starts, for {size_choice.LONGEST:g} s at most",
    f"({size_choice.SHARE / 30 * 1e3:.1f} ms at 30 fps",
    f"walks at {visitor._SPEED} m/s between five places",
    f"stays {visitor._STAY[0]:g} to {visitor._STAY[1]:g} s at each",
    f"goes elsewhere after {visitor._PATIENCE:g} s",
    f"makes room for a figure that comes closer than {visitor._NOTICE:.1f} m",
    f"from {life._EARSHOT:g} m on it is heard",
    f"comes close again {shot._LINGER} s after it stands",
)
PERFORMANCE = (f"Ways over up to {wayfinding._SMALL} corners take a few milliseconds",)
ENGINE_LINK = (
    f"the newest {connection.MAX_QUEUED_SOUND} blocks are kept",
    f"or more than {picture_source.MAX_AGE:g} s ago, is not believed",
    f"Up to {picture_source.MAX_AHEAD} s in the future is believed",
    f"has needed, at most {engine_sound.LONGEST_LAG} s",
    f"have at most {reading.MAX_NAME} characters, texts and reasons {reading.MAX_TEXT:,}",
    f"the adapter's log, which takes {body._LINES} a second",
    f"while it moves up to {1 / life._PLACES:g} times a second",
    f"when something changes, up to {1 / life._THINGS:g} times a second",
    f"`reactions` has at most {greeting.MAX_REACTIONS} names",
    f"A path has at most {motion.MAX_PATH:,} points, a floor {motion.MAX_OBSTACLES} obstacles",
    f"{motion.MAX_CORNERS:,} corners together, a scene {motion.MAX_THINGS} things",
    f"one `speak` has at most {gestures.MAX_VISEMES:,}",
    f"`turn` in rad/s, at most {motion.MAX_SPEED:g}. Coordinates are {motion.FAR:,.0f} at most",
    f"sends HELLO within {server.GREETING_TIMEOUT:g} s",
    f"more than {server.MAX_STRANGERS} connections have not greeted yet",
    f"leaves {connection.MAX_UNREAD // 1024} KiB of commands unread",
    f"until the engine closes, for {connection.FAREWELL_TIMEOUT} s at most; then it cuts",
    f"sends no picture for {HUNG:g} s without a pause",
    f"or none in the {external.FIRST_PICTURE:g} s after its greeting, hangs",
    f"HELLO has to come within {embedded.START_TIMEOUT:g} s of the start",
    f"after {embedded.FIRST_DELAY} s, then twice as long each time, at most {embedded.LONGEST_DELAY:g} s",
    f"The end is `quit`, {embedded.QUIT_TIMEOUT} s later SIGTERM, {child.TERMINATE_TIMEOUT} s later SIGKILL",
    f"goes to the adapter's log, at most {child.MAX_LINES} lines a second",
)


@pytest.mark.parametrize(
    ("page", "sentences"),
    [
        ("reference/avatar.md", AVATAR),
        ("reference/engine-link.md", ENGINE_LINK),
        ("explanation/performance.md", PERFORMANCE),
    ],
    ids=["avatar", "engine-link", "performance"],
)
def test_the_numbers_of_a_page_are_those_of_the_product(page: str, sentences: tuple[str, ...]) -> None:
    text = text_of(page)
    assert [each for each in sentences if each not in text] == []


def test_numbers_that_are_written_as_words() -> None:
    assert reconnecting.FIRST_DELAY == 0.5, "half a second between attempts, growing to 5 s"
    assert reconnecting.LONGEST_DELAY == 5
    assert len(visitor.PLACES) == 5, "between five places"
    assert ear.GONE == 0.5, "ends also with the microphone, after half a second"
    assert watch.RATE == 10, "ten pictures a second at most"
    assert playout_delay.JITTERS == 3, "three times the jitter"
    assert head_gestures._SWINGS == 3, "three swings of the head"
    assert devices.LEVEL_INTERVAL == 1 / 5, "five times a second at most"
