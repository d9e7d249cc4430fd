"""`openrois avatar check` with engines that do all as they should, and with engines that each do one thing wrong."""

import asyncio
import json
import re
import shutil
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest
from openrois_avatar import command as avatar
from openrois_avatar.check import command
from openrois_avatar.check.command_checks import Patience
from openrois_avatar.check.finding import Finding, Outcome
from openrois_avatar.check.session import check_session

from tests.support.odd_engine import odd_engine

ROOT = Path(__file__).parents[3]
SHORT = Patience(connect=10, greet=0.5, watch=0.5, answer=0.6, react=1.0, come_back=1.0, end=5.0)
LONG = Patience(connect=20, watch=1.0, answer=5.0, asleep=3.0, come_back=2.0)
PUPPET = ("-m", "openrois_avatar.engines.puppet", "--size", "160x90", "--fps", "10")
AT_ONCE = 18
"""Engines that are checked side by side: they wait most of the time, but a busy machine makes them late."""
SECRET = "s3cret"

ODD = {
    "says nothing": ("greeting", "no HELLO came within 0.5 s"),
    "speaks HTTP": ("greeting", "bad magic"),
    "wrong secret": ("greeting", "HELLO does not have the secret"),
    "shows nothing": ("pictures", "none has come"),
    "is slow": ("pictures", "a second, 25 announced"),
    "counts on": ("sequence", "after the connection: every connection counts from 0"),
    "does not count": ("sequence", "number 0 follows 0"),
    "is small": ("size", "HELLO announced 16x8 bgra, and 8x8 bgra came"),
    "has no time": ("moments", "the timestamp is 0"),
    "has the time of day": ("moments", "CLOCK_MONOTONIC in nanoseconds, no other clock"),
    "is late": ("moments", "ago, which is not believed"),
    "is ahead": ("moments", "later than now, which is not believed"),
    "stands still": ("moments", "do not show a later moment"),
    "silent says HELLO": ("sound", "HELLO has no `audio`, and sound came"),
    "is stereo": ("sound", "1 channels were announced, and blocks have 2"),
    "counts no sound": ("sound", "not counted from 0 on"),
    "sounds late": ("sound moments", "s too late"),
    "sounds of the past": ("sound moments", "from -1 to 0.5 s is believed"),
    "stumbles": ("sound moments", "do not begin within 30 ms"),
    "nods for ever": ("reaction", "nod was not completed within 1 s"),
    "nods twice": ("answers", "completed more than once"),
    "does not stop": ("stop", "nod was not completed within 0.6 s of `stop`"),
    "stops with ERROR": ("stop", "completed with ERROR when it was stopped"),
    "knows everything": ("unknown", "completed with OK, not with ERROR"),
    "ignores what it does not know": ("unknown", "was not answered within 0.6 s"),
    "sleeps with open eyes": ("demand", "pictures came while none were wanted"),
    "sleeps for ever": ("demand", "no picture came for 0.6 s when it was wanted"),
    "sleeps like the dead": ("demand", "no `idle` came in 1 s"),
    "sleeps and shows its dream": ("demand", "shows a moment before it was wanted"),
    "dies of sound": ("hearing", "after 20 blocks of the operator's sound: "),
    "dies of input": ("input", "after a key, a pointer, a wheel, a gamepad and `release`: "),
    "has no place": ("walk", "no `place` came after the greeting"),
    "does not tell": ("walk", "`reached` came for the points [], not for 0 and 1"),
    "does not halt": ("halt", "completed with OK, not ABORT"),
    "does not drive": ("drive", "moved nothing"),
    "drives for ever": ("drive", "it still moves"),
    "ring unused": ("ring", "no picture came through it"),
    "ring with wrong locks": ("protocol", "its lock word is 1 and should be "),
}
"""What is wrong with an engine, the check that finds it, and what it says."""

RIGHT = ("nothing", "sleeps", "ring used", "can nothing", "comes back", "pauses", "is mute", "loses the first")
"""Engines with which nothing is wrong."""


@dataclass
class Found:
    """What a check has found, by the name of what was tried."""

    findings: list[Finding]

    def __contains__(self, check: str) -> bool:
        return any(finding.check == check for finding in self.findings)

    def __getitem__(self, check: str) -> Finding:
        (finding,) = (finding for finding in self.findings if finding.check == check)
        return finding

    @property
    def failed(self) -> list[str]:
        """What failed, but for the pace: many engines draw at once here, and a busy machine makes each of them skip."""
        told = [f"{each.check}: {each.seen}" for each in self.findings if each.outcome is Outcome.FAILED]
        return [each for each in told if not re.match(r"pictures: [\d.]+ a second", each)]


async def of_thread(odd: str, turn: asyncio.Semaphore) -> Found:
    """Check an engine in a thread."""
    patience = LONG if odd in RIGHT else SHORT
    async with turn, check_session("tcp:127.0.0.1:0", SECRET, (), patience) as session:
        engine = odd_engine(session.address, SECRET, odd)
        engine.__enter__()
        found = [finding async for finding in session.findings()]
        await asyncio.to_thread(engine.__exit__, None, None, None)
    return Found(found)


async def of_process(*arguments: str, program: str = sys.executable) -> Found:
    """Check an engine that the check starts."""
    async with check_session("tcp:127.0.0.1:0", SECRET, [program, *arguments], LONG) as session:
        return Found([finding async for finding in session.findings()])


@pytest.fixture(scope="module")
def found() -> dict[str, Found]:
    """All of them, many at once."""

    async def check_all() -> dict[str, Found]:
        turn = asyncio.Semaphore(AT_ONCE)
        async with asyncio.timeout(100), asyncio.TaskGroup() as tasks:
            running = {odd: tasks.create_task(of_thread(odd, turn)) for odd in (*RIGHT, *ODD)}
            running["puppet"] = tasks.create_task(of_process(*PUPPET))
            running["encoder"] = tasks.create_task(of_process("-m", "tests.support.encoding_engine"))
            running["example"] = tasks.create_task(of_process(str(ROOT / "docs/examples/engine.py")))
            if (node := shutil.which("node")) is not None:
                script = str(ROOT / "docs/examples/engine.mjs")
                running["script"] = tasks.create_task(of_process(script, program=node))
        return {odd: task.result() for odd, task in running.items()}

    return asyncio.run(check_all())


@pytest.mark.engine
@pytest.mark.parametrize("odd", ODD)
def test_fault_is_named(found: dict[str, Found], odd: str) -> None:
    check, said = ODD[odd]
    assert said in found[odd][check].seen
    assert found[odd][check].outcome is Outcome.FAILED


@pytest.mark.engine
@pytest.mark.parametrize("engine", [*RIGHT, "puppet", "encoder", "example"])
def test_correct_engine_passes(found: dict[str, Found], engine: str) -> None:
    assert found[engine].failed == []


@pytest.mark.engine
def test_the_example_in_javascript_passes_and_comes_back(node: Path, found: dict[str, Found]) -> None:
    assert found["script"].failed == []
    assert found["script"]["walk"].outcome is Outcome.PASSED
    assert found["script"]["adapter gone"].seen == "the engine connected again, and greeted anew"


@pytest.mark.engine
def test_an_engine_that_encodes_is_asked_for_a_key_frame(found: dict[str, Found]) -> None:
    assert found["encoder"]["key frame"].outcome is Outcome.PASSED
    assert found["puppet"]["key frame"].outcome is Outcome.NOT_TRIED


@pytest.mark.engine
def test_how_engines_end_is_told(found: dict[str, Found]) -> None:
    ends = {
        engine: (found[engine]["adapter gone"].seen, found[engine]["quit"].seen)
        for engine in found
        if "quit" in found[engine]
    }
    assert ends["comes back"] == ("the engine connected again, and greeted anew", "the engine closed its connection")
    assert ends["nothing"][0].startswith("the engine did not connect again within 2 s")
    assert ends["nothing"][1] == "the engine does not connect again"
    for started in ("puppet", "encoder", "example"):
        assert ends[started] == ("the engine ended, with status 0", "the engine ended with status 0")


@pytest.mark.engine
def test_every_section_is_on_the_page(found: dict[str, Found]) -> None:
    page = (ROOT / "docs/reference/engine-link.md").read_text()
    sections = {finding.section for each in found.values() for finding in each.findings}
    assert [section for section in sections if f"\n## {section}\n" not in page] == []


def test_the_page_has_the_example_as_it_is() -> None:
    page = (ROOT / "docs/how-to/engine.md").read_text()
    assert (ROOT / "docs/examples/engine.py").read_text() in page.replace("```\n", "")


def hanging(told: str) -> list[str]:
    """A program that says it is an engine and is none."""
    return [sys.executable, "-c", told]


@pytest.mark.parametrize(
    ("program", "said"),
    [
        ("raise SystemExit(7)", "the engine ended with status 7 before it connected"),
        ("import time; time.sleep(60)", "no engine connected to tcp:127.0.0.1:"),
    ],
)
def test_an_engine_that_does_not_come(capsys: pytest.CaptureFixture[str], program: str, said: str) -> None:
    patience = Patience(connect=1.0)
    status = asyncio.run(command.check("tcp:127.0.0.1:0", SECRET, hanging(program), patience, json=True))
    told = json.loads(capsys.readouterr().out)
    assert (status, told["passed"], told["engine"]) == (1, False, None)
    assert [(each["check"], each["outcome"]) for each in told["findings"]] == [("connection", "failed")]
    assert said in told["findings"][0]["seen"]


def test_the_command_says_what_it_waits_for_and_what_it_found(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    address = f"unix:{tmp_path}/engine"
    assert avatar.main(["check", "--link", address, "--wait", "0"]) == 1
    waiting, finding, _, summed_up = capsys.readouterr().out.splitlines()
    assert waiting == f"waiting for an engine at {address}"
    assert finding == (
        f"FAILED connection       no engine connected to {address} within 0 s; --wait gives it longer "
        "(docs/reference/engine-link.md, From the greeting to the end)"
    )
    assert summed_up == "The engine does not follow docs/reference/engine-link.md: 1 failed."


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--link", "tcp:192.0.2.1:1"], "is no loopback address"),
        (["--", "no/such/engine"], "no/such/engine cannot be started: No such file or directory"),
    ],
)
def test_check_that_cannot_start_says_why(capsys: pytest.CaptureFixture[str], arguments: list[str], said: str) -> None:
    assert avatar.main(["check", *arguments]) == 1
    assert said in capsys.readouterr().err


def test_wrong_usage_is_explained(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        avatar.main(["check", "--link-secret-file", "no/such/file"])
    assert "--link-secret-file" in capsys.readouterr().err
