"""What a type checker sees of an application: every wrong name and type, and nothing that is right."""

import re
import subprocess
import sys
import textwrap
from pathlib import Path
from typing import Final

import pytest

import openrois.client

pytestmark = pytest.mark.extra(name="dev")

ROOT: Final = Path(__file__).parents[3]

APPLICATION: Final = """
from collections.abc import AsyncIterator
from typing import assert_type

from openrois.catalog.actuation import NavigationParameters, ReachedTarget
from openrois.catalog.sensing import PersonDetected
from openrois.catalog.system_information import EngineStatusResult
from openrois.client import Body, BodyInfo, Client, Command, ComponentProxy, Event, Fault, Feed, Notice
from openrois.client import Step, Subscription, concurrent
from openrois.client.components import Move, Navigation, PersonDetection, SpeechSynthesis, SystemInformation
from openrois.client.components import VideoStreaming
from openrois.catalog.component_type import ComponentType
from openrois.types.codes import ComponentStatus, StreamStatus

LAMP = ComponentType(code="Lamp", name="lamp", description="A lamp.", source="Example", authority="Example")


async def right(client: Client) -> None:
    navigation = client.component(Navigation, "robot/navigation")
    assert_type(navigation, Navigation)
    assert_type(await client.find(PersonDetection), PersonDetection)
    assert_type(await client.find_all(Move), list[Move])
    assert_type(client.component("x/lamp"), ComponentProxy)
    assert_type(navigation.set(target_positions=["lobby"], time_limit=5), Step[None])
    assert_type(await navigation.start().execute(), Command[None])
    assert_type(await navigation.component_status(), ComponentStatus)
    assert_type(await navigation.parameters(), NavigationParameters)
    async for reached in navigation.reached_target():
        assert_type(reached, ReachedTarget)
    async for event in client.component(PersonDetection, "robot/persons").person_detected().events():
        assert_type(event, Event[PersonDetected])
    assert_type(await client.component(SpeechSynthesis, "x/y").available_voices(), tuple[str, ...])
    assert_type(await client.component(SystemInformation, "x/y").engine_status(), EngineStatusResult)
    assert_type(await client.component(VideoStreaming, "x/y").get_stream_status("s"), StreamStatus)
    assert_type(client.notices(Fault), Feed[Fault])
    assert_type(client.notices(), Feed[Notice])
    async with client.body(Navigation, "Bell", optional=(Move, LAMP)) as body:
        assert_type(body, Body)
        assert_type(body[Navigation], Navigation)
        assert_type(body["Bell"], ComponentProxy)
        assert_type(body.get(Move), Move | None)
        assert_type(body.get(LAMP), ComponentProxy | None)
    assert_type(await client.bodies(), list[BodyInfo])
    await client.run(navigation.set(target_positions=("hall",)), concurrent(navigation.start()).after(1.5))
    async with navigation.bound():
        await client.component(Move, "robot/move").set(line=[100, 0], time=2000)


async def wrong(client: Client) -> None:
    navigation = client.component(Navigation, "robot/navigation")
    await navigation.set(target_position=["lobby"])  # error: call-arg
    await navigation.set(target_positions="lobby")  # error: arg-type
    await navigation.set(target_positions=[1])  # error: list-item
    await navigation.set(time_limit="soon")  # error: arg-type
    await navigation.set(["lobby"])  # error: call-arg
    await navigation.begin()  # error: attr-defined
    await navigation.start(at_once=True)  # error: call-arg
    navigation.person_detected()  # error: attr-defined
    async for person in client.component(PersonDetection, "robot/persons").person_detected():
        print(person.count)  # error: attr-defined
    (await navigation.component_status()).upside_down  # error: attr-defined
    await client.find("Navigation")  # error: call-overload
    await client.execute("start")  # error: arg-type
    await client.bind(navigation)  # error: arg-type
    client.body(1)  # error: arg-type
    async with client.body(Navigation) as body:
        body[1]  # error: call-overload
    Client(retries=3)  # error: call-arg
"""


GUIDE: Final = """
from openrois.client import Client
from openrois.client.components import Navigation, SpeechSynthesis

client: Client
navigation: Navigation
speech: SpeechSynthesis
"""
"""What the guide's pieces take for granted."""


def guide() -> dict[str, str]:
    """Return the guides' pieces of Python as modules: what stands at their top, and a function with what awaits."""
    text = "".join((ROOT / "docs/how-to" / page).read_text(encoding="utf-8") for page in ("client.md", "bodies.md"))
    modules = {}
    pieces = re.findall(r"^```python\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)
    # Whole programs are checked where they are.
    for number, piece in enumerate(piece for piece in pieces if "if __name__" not in piece):
        imports = "".join(re.findall(r"^from .*\n", piece, re.MULTILINE))
        rest = textwrap.indent(re.sub(r"^from .*\n", "", piece, flags=re.MULTILINE), "    ")
        # A piece that has a client of its own hides the one that is taken for granted.
        modules[f"guide_{number}"] = f"{GUIDE}{imports}async def piece(client: Client = client) -> None:\n{rest}"
    return modules


def mypy(folder: Path) -> str:
    """Check what is in a folder; return what mypy says."""
    command = [sys.executable, "-m", "mypy", "--strict", "--config-file=", "--no-error-summary", "--hide-error-context"]
    checked = subprocess.run([*command, folder], cwd=ROOT, capture_output=True, check=False, text=True, timeout=280)
    return checked.stdout + checked.stderr


@pytest.mark.timeout(300)
def test_the_guide_is_right(tmp_path: Path) -> None:
    pieces = guide()
    assert len(pieces) == 12
    for name, text in pieces.items():
        (tmp_path / f"{name}.py").write_text(text)
    assert mypy(tmp_path) == ""


def test_what_the_guide_says_is_raised_comes_from_the_client() -> None:
    text = (ROOT / "docs" / "how-to" / "client.md").read_text(encoding="utf-8")
    table = text.partition("| raised | when |")[2].partition("\n\n")[0]
    raised = re.findall(r"`(\w+)`", "".join(re.findall(r"^\| (`.*?) \|", table, re.MULTILINE)))
    assert len(raised) == 10
    assert {*raised} - {*openrois.client.__all__} == {"TimeoutError"}


@pytest.mark.timeout(300)
def test_a_type_checker_finds_what_is_wrong_and_nothing_else(tmp_path: Path) -> None:
    (tmp_path / "application.py").write_text(APPLICATION)
    said = mypy(tmp_path)
    found = re.findall(r"^.*application\.py:(\d+): error: .*\[([\w-]+)\]$", said, re.MULTILINE)
    lines = APPLICATION.splitlines()
    expected = [(str(n), line.partition("# error: ")[2]) for n, line in enumerate(lines, 1) if "# error: " in line]
    assert found == expected, said
