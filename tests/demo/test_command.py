"""`openrois demo` as a person starts and stops it."""

import asyncio
import os
import re
import signal
import socket
import time
from collections.abc import Callable
from pathlib import Path
from typing import ClassVar

import psutil
import pytest
from aiohttp import ClientSession
from openrois_demo import command as demo_module
from openrois_demo.program import ProgramFailed

from openrois.auth.issuing import issue_token
from openrois.auth.key_files import make_key_files
from openrois.auth.principal import Role
from openrois.client import Client
from openrois.client.components import Navigation, SystemInformation
from openrois.client.errors import ConnectionFailed
from openrois.errors import OutOfResources
from tests.support.certificates import Authority
from tests.support.demo import PATIENCE, Demo, end, first_line, free_port, hand_back, running_demo, start
from tests.support.streaming import settle

pytestmark = pytest.mark.media


def ctrl_c_twice(demo: Demo) -> None:
    """Send the signal to the whole process group, as a terminal does, repeatedly."""
    os.killpg(demo.process.pid, signal.SIGINT)
    os.killpg(demo.process.pid, signal.SIGINT)


def interrupt(demo: Demo) -> None:
    demo.process.send_signal(signal.SIGINT)


def interrupt_while_the_adapter_is_stopped(demo: Demo) -> None:
    demo.program("avatar").send_signal(signal.SIGSTOP)
    demo.process.send_signal(signal.SIGINT)


@pytest.mark.parametrize(
    "stop",
    [
        pytest.param(ctrl_c_twice, marks=pytest.mark.long),
        interrupt,
        pytest.param(interrupt_while_the_adapter_is_stopped, marks=pytest.mark.long),
    ],
)
def test_a_demo_that_is_stopped_leaves_nothing_behind(tmp_path: Path, stop: Callable[[Demo], None]) -> None:
    with running_demo(tmp_path) as demo:
        assert demo.ready == f"ready http://127.0.0.1:{demo.port}/"
        tree = demo.tree()
        assert len(tree) == 2
        stop(demo)
        assert demo.process.wait(20) == 0
        assert not [process for process in tree if process.is_running()]
        assert "Traceback" not in demo.log()
        assert port_is_free(demo.port)


@pytest.mark.parametrize(
    ("engine", "processes"), [("synthetic", 2), pytest.param("puppet", 3, marks=[pytest.mark.engine, pytest.mark.long])]
)
def test_a_demo_that_is_killed_takes_all_it_started_with_it(tmp_path: Path, engine: str, processes: int) -> None:
    with running_demo(tmp_path, engine) as demo:
        tree = demo.tree()
        assert len(tree) == processes
        demo.process.kill()
        assert not psutil.wait_procs(tree, timeout=PATIENCE)[1]


async def test_demo_for_other_machines_refuses_a_client_without_a_token(tmp_path: Path) -> None:
    authority = Authority(tmp_path)
    cert, cert_key = authority.issue()
    make_key_files(tmp_path / "key", "ES256")
    reached = ("--host", "0.0.0.0", "--allow-host", "localhost", "--tls-cert", str(cert), "--tls-key", str(cert_key))
    trusted = ("--auth-key", str(tmp_path / "key"), "--ca-file", str(authority.file))
    with running_demo(tmp_path, more=(*reached, *trusted)) as demo:
        assert demo.ready == f"ready https://localhost:{demo.port}/"
        url = f"wss://localhost:{demo.port}/"
        with pytest.raises(ConnectionFailed):
            async with Client(url, ca_file=authority.file):
                pass
        token = issue_token(tmp_path / "key", "anna", [Role.VIEWER], ["avatar/*"], now=int(time.time()), ttl=60)
        async with Client(url, token=token, ca_file=authority.file) as client:
            assert await client.find(SystemInformation)
        assert demo.interrupt() == 0


@pytest.mark.engine
async def test_a_visitor_of_the_page_goes_before_a_program_that_shows_no_token(tmp_path: Path) -> None:
    with running_demo(tmp_path, more=("--with", "robot")) as demo:
        async with ClientSession() as session, session.get(f"{demo.page}page-token") as answer:
            token = (await answer.json())["token"]
        async with Client(demo.url) as program, Client(demo.url, token=token) as visitor:
            legs = await program.find(Navigation)
            await legs.bind()
            lease = await visitor.control.borrow(legs.component_ref)
            assert (lease.holder, lease.lender, lease.part) == ("visitor 1", "local", "legs")
            with pytest.raises(OutOfResources, match="taken for a time by visitor 1"):
                await legs.start()

            await visitor.control.stop_all("robot")
            assert (await program.control.status(legs.component_ref)).stopped_by == "visitor 1"
            await hand_back(demo)
            assert not (await program.control.status(legs.component_ref)).stopped_by
        assert demo.interrupt() == 0


def test_a_second_demo_on_the_same_port_says_so_in_one_line(tmp_path: Path) -> None:
    with running_demo(tmp_path) as demo:
        second = start("demo", "--engine", "synthetic", "--port", str(demo.port))
        output, complaint = second.communicate(timeout=PATIENCE)
        assert (second.returncode, output) == (1, "")
        assert re.fullmatch(rf"openrois demo: .*\b{demo.port}\b.*\n", complaint)
        assert demo.process.poll() is None


@pytest.mark.long
def test_a_port_is_free_again_at_once(tmp_path: Path) -> None:
    with running_demo(tmp_path) as demo:
        with socket.create_connection(("127.0.0.1", demo.port)):
            demo.interrupt()
        again = start("demo", "--engine", "synthetic", "--port", str(demo.port))
        try:
            assert first_line(again) == demo.ready
        finally:
            end(again)


def test_an_avatar_is_never_stamped(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        demo_module.main(["--engine", "puppet", "--stamp"])
    assert "--stamp cannot be used with --engine puppet" in capsys.readouterr().err


@pytest.mark.parametrize("port", ["0", "-1", "65536", "http"])
def test_malformed_port_is_wrong_usage(port: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as refusal:
        demo_module.main([f"--port={port}"])
    assert refusal.value.code == 2
    assert f"argument --port: '{port}' is not a port from 1 to 65535 (" in capsys.readouterr().err


class Unready:
    """Stands in for a program that does not become ready: it ends, or it hangs."""

    ends = True
    made: ClassVar[dict[str, tuple[str, ...]]] = {}

    def __init__(self, arguments: tuple[str, ...], announces: str, **_more: object) -> None:
        self.name = arguments[0]
        self.made[self.name] = arguments
        self.ready = asyncio.Event()

    async def keep_running(self) -> None:
        if self.ends:
            raise ProgramFailed("it fell over")
        await self.ready.wait()


class Lasting(Unready):
    """Stands in for a program that is ready at once, and takes some turns of the loop to end; a mind takes more."""

    ended: ClassVar[list[str]] = []

    async def keep_running(self) -> None:
        self.ready.set()
        if self.name == "mind":
            os.kill(os.getpid(), signal.SIGINT)
        try:
            await asyncio.Event().wait()
        finally:
            for _ in range(5 if self.name == "mind" else 1):
                await settle()
            self.ended.append(self.name)


class Seeing:
    """Stands in for a watchdog that sees all bodies."""

    def __init__(self, *_arguments: object, **_options: object) -> None: ...

    async def until_there(self) -> None: ...

    async def watch(self, *_programs: object) -> None: ...


def test_the_mind_ends_before_the_gateway_and_the_bodies_that_it_takes_leave_of(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(demo_module, "set_up_logging", lambda *, verbose: None)
    monkeypatch.setattr(demo_module, "Program", Lasting)
    monkeypatch.setattr(demo_module, "Watchdog", Seeing)
    assert demo_module.main(["--port", str(free_port()), "--mind"]) == 0
    assert Lasting.ended[0] == "mind"
    assert sorted(Lasting.ended[1:]) == ["avatar", "gateway"]


@pytest.mark.parametrize(
    ("ends", "complaint"),
    [(True, "it fell over"), (False, "gateway is not ready after 0 s; --verbose logs more")],
    ids=["ends", "hangs"],
)
def test_a_program_that_does_not_become_ready_ends_the_demo_with_a_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], ends: bool, complaint: str
) -> None:
    monkeypatch.setattr(demo_module, "set_up_logging", lambda *, verbose: None)
    monkeypatch.setattr(demo_module, "Program", Unready)
    monkeypatch.setattr(demo_module, "_START_TIMEOUT", 0.01)
    monkeypatch.setattr(Unready, "ends", ends)
    assert demo_module.main(["--port", str(free_port())]) == 1
    assert capsys.readouterr() == ("", f"openrois demo: {complaint}\n")


def test_limits_of_applications_are_passed_to_the_avatar(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(demo_module, "set_up_logging", lambda *, verbose: None)
    monkeypatch.setattr(demo_module, "Program", Unready)
    given = ["--applications", "8", "--kept-for-operators", "2", "--answer-time", "1.5"]
    demo_module.main(["--port", str(free_port()), *given])
    avatar = Unready.made["avatar"]
    assert list(avatar[(start := avatar.index("--applications")) : start + len(given)]) == given


def test_a_robot_beside_the_avatar_gets_what_concerns_it(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(demo_module, "set_up_logging", lambda *, verbose: None)
    monkeypatch.setattr(demo_module, "Program", Unready)
    monkeypatch.setattr(Unready, "made", {})
    make_key_files(tmp_path / "key", "HS256")
    network = ["--interface", "lo", "--udp-ports", "50000-50100", "--applications", "8"]
    given = ["--with", "robot", "--visitor", "--size", "640x360", "--auth-key", str(tmp_path / "key"), *network]
    demo_module.main(["--port", str(port := free_port()), *given])
    assert Unready.made.keys() == {"gateway", "avatar", "robot"}
    robot, avatar = list(Unready.made["robot"]), list(Unready.made["avatar"])
    assert robot[:3] == ["robot", "simulated", "--visitor"]
    for option, value in zip(network[::2], network[1::2], strict=True):
        assert robot[robot.index(option) + 1] == avatar[avatar.index(option) + 1] == value
    assert robot[robot.index("--gateway") + 1] == f"ws://127.0.0.1:{port}/adapter"
    tokens = [each[each.index("--token-file") + 1] for each in (robot, avatar)]
    assert [Path(token).name for token in tokens] == ["robot.token", "avatar.token"]
    assert "--size" not in robot


def test_a_token_for_another_gateway_is_shown_to_none_of_its_own(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(demo_module, "set_up_logging", lambda *, verbose: None)
    monkeypatch.setattr(demo_module, "Program", Unready)
    monkeypatch.setattr(Unready, "made", {})
    monkeypatch.setenv("OPENROIS_TOKEN_FILE", str(tmp_path / "token"))
    demo_module.main(["--port", str(free_port())])
    assert "OPENROIS_TOKEN_FILE" not in os.environ
    assert "--auth-local" in Unready.made["gateway"]
    assert "--token-file" not in Unready.made["avatar"]


def test_without_a_wish_there_is_no_robot(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(demo_module, "set_up_logging", lambda *, verbose: None)
    monkeypatch.setattr(demo_module, "Program", Unready)
    monkeypatch.setattr(Unready, "made", {})
    demo_module.main(["--port", str(free_port())])
    assert Unready.made.keys() == {"gateway", "avatar"}


@pytest.mark.engine
async def test_a_program_that_shows_what_the_demo_has_written_is_called_by_its_rank(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with running_demo(tmp_path, more=("--with", "robot")) as demo:
        assert demo.process.stdout is not None
        told = [demo.process.stdout.readline() for _ in range(2)]
        files = dict(re.findall(r"for a program, as (\w+): OPENROIS_TOKEN_FILE=(\S+)", "".join(told)))
        assert files.keys() == {"agent", "script"}
        async with Client(demo.url) as nameless:
            legs = await nameless.find(Navigation)
            for rank in files:
                monkeypatch.setenv("OPENROIS_TOKEN_FILE", files[rank])
                async with Client(demo.url) as program:
                    await program.bind(legs.component_ref)
                    assert (await nameless.control.status(legs.component_ref)).holder == rank
        assert demo.interrupt() == 0


@pytest.mark.long
@pytest.mark.engine
def test_a_robot_beside_the_avatar_is_started_again_when_it_is_killed(tmp_path: Path) -> None:
    with running_demo(tmp_path, more=("--with", "robot")) as demo:
        first = demo.program("robot")
        engine_ids = asyncio.run(engines(demo.url, lambda found: "robot" in found))
        assert {"avatar", "robot"} <= set(engine_ids)
        first.kill()
        asyncio.run(engines(demo.url, lambda found: "robot" not in found))
        asyncio.run(engines(demo.url, lambda found: "robot" in found))
        assert demo.program("robot").pid != first.pid
        assert demo.interrupt() == 0


async def engines(url: str, wanted: Callable[[tuple[str, ...]], bool]) -> tuple[str, ...]:
    """Wait until the gateway has the engines that are wanted, and return their ids."""
    async with asyncio.timeout(PATIENCE), Client(url) as client, client.notices() as notices:
        while True:
            profile = (await client.get_profile()).profile
            assert profile is not None
            if wanted(profile.engine_ids()):
                return profile.engine_ids()
            await anext(aiter(notices))


def test_places_that_cannot_be_are_wrong_usage(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        demo_module.main(["--applications", "4", "--kept-for-operators", "4"])
    assert "--kept-for-operators must be between 0 and 3, below --applications, not 4" in capsys.readouterr().err


def port_is_free(port: int) -> bool:
    with socket.socket() as probe:
        probe.settimeout(1)
        return probe.connect_ex(("127.0.0.1", port)) != 0
