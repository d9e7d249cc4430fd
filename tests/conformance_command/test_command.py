"""`openrois conformance`: what it prints, what it writes, how it ends."""

import asyncio
import json
import os
import subprocess
import sys
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import pytest
from openrois_conformance import command
from openrois_conformance.manifest import read_manifest

from openrois import adapter as adapting
from openrois.adapter import components
from openrois.transport.credentials import CA_FILE_VARIABLE, TOKEN_FILE_VARIABLE
from tests.support import deployment
from tests.support.bent import bent
from tests.support.certificates import Authority
from tests.support.guarded import fresh, guarded

pytestmark = pytest.mark.extra(name="gateway")


@pytest.fixture(autouse=True)
def _wide(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "100")


async def run(*arguments: str) -> int:
    """Run the command beside this event loop."""
    return await asyncio.to_thread(command.main, arguments)


class TestManifest:
    def test_the_table_has_every_requirement_and_ends_with_the_gaps(self, capsys: pytest.CaptureFixture[str]) -> None:
        assert command.main([]) == 0
        lines = capsys.readouterr().out.splitlines()
        for area in read_manifest():
            assert area.title in lines
            for requirement in area.requirements:
                assert any(line.startswith(f"{requirement.id} ") for line in lines), requirement.id
        gaps = [requirement for area in read_manifest() for requirement in area.requirements if requirement.gap]
        (at,) = [number for number, line in enumerate(lines) if "are not met, or met otherwise:" in line]
        assert lines[at].split()[0] == str(len(gaps))
        named = [line.split(":")[0].strip() for line in lines[at + 1 :]]
        assert [requirement.id for requirement in gaps if requirement.id not in named] == []
        assert all(len(line) <= 100 for line in lines if line.startswith("    "))

    def test_a_closed_pipe_is_no_failure(self) -> None:
        reader, writer = os.pipe()
        os.close(reader)
        program = [sys.executable, "-m", "openrois.cli", "conformance"]
        ended = subprocess.run(program, stdout=writer, stderr=subprocess.PIPE, check=False, timeout=30)
        os.close(writer)
        assert (ended.returncode, ended.stderr) == (0, b"")

    def test_part_of_it(self, capsys: pytest.CaptureFixture[str]) -> None:
        assert command.main(["--only", "query.*"]) == 0
        shown = capsys.readouterr().out
        assert "The Query interface" in shown
        assert "The Event interface" not in shown

    def test_by_the_name_of_a_check(self, capsys: pytest.CaptureFixture[str]) -> None:
        assert command.main(["--only", "bind-exclusive"]) == 0
        assert "command.bind " in capsys.readouterr().out

    def test_as_json(self, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
        assert command.main(["--only", "query.*", "--json", str(tmp_path / "manifest.json")]) == 0
        (area,) = json.loads((tmp_path / "manifest.json").read_text(encoding="utf-8"))["areas"]
        first = area["requirements"][0]
        assert (area["name"], first["id"], first["level"]) == ("query", "query.query", "shall")
        assert first["checks"] == ["query"]
        named = next(each["tests"] for each in area["requirements"] if each["id"] == "query.unusable")
        assert named == ["conformance/test_query.py::test_a_component_that_cannot_work_tells_its_status_only"]

    def test_the_page_ends_in_what_the_command_prints(self, capsys: pytest.CaptureFixture[str]) -> None:
        assert command.main(["--markdown"]) == 0
        page = Path(__file__).parents[2] / "docs" / "reference" / "conformance.md"
        assert page.read_text(encoding="utf-8").endswith(f"-->\n\n{capsys.readouterr().out}"), "run `make generate`"


class TestRun:
    async def test_a_gateway_that_conforms(self, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
        async with trying() as url:
            assert await run("--url", url, "--only", "query.*", "--json", str(tmp_path / "run.json")) == 0
        lines = capsys.readouterr().out.splitlines()
        assert lines[0] == f"{url} is gateway; it speaks rois.stream, signaling, openrois.directory, openrois.lease"
        assert "The Query interface" in lines
        assert any(line.startswith("pass     query.selection") for line in lines)
        assert lines[-2:] == [
            "6 requirements: 6 passed, 0 failed, 0 tried in part, 0 not run",
            "1 more requirement cannot be seen from outside: see `openrois conformance`",
        ]
        written = json.loads((tmp_path / "run.json").read_text(encoding="utf-8"))
        assert {each["standing"] for each in written["requirements"]} == {"pass"}
        assert written["requirements"][0]["checks"][0]["frames"] == []

    async def test_one_that_does_not(self, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
        def more(message: Any, method: str) -> list[Any]:
            extra = method == "rois.query.query" and "result" in message
            return [{**message, "result": {**message["result"], "more": 1}}] if extra else [message]

        async with trying() as url, bent(url, to_application=more) as proxy:
            assert await run("--url", proxy.url, "--only", "query.query", "--json", str(tmp_path / "run.json")) == 1
        shown = capsys.readouterr().out
        assert "FAIL     query.query" in shown
        assert "expected  a result of rois.query.query that fits (more: Extra inputs are not permitted)" in shown
        assert "came      {" in shown
        assert 'application 1 <- {"jsonrpc": "2.0"' in shown
        assert "1 requirement: 0 passed, 1 failed, 0 tried in part, 0 not run" in shown
        (written,) = json.loads((tmp_path / "run.json").read_text(encoding="utf-8"))["requirements"]
        assert (written["standing"], written["checks"][0]["outcome"]) == ("FAIL", "FAIL")
        assert written["checks"][0]["frames"]

    async def test_a_check_that_failed_is_shown_once(self, capsys: pytest.CaptureFixture[str]) -> None:
        def mislead(message: Any, method: str) -> list[Any]:
            found = method == "rois.event.subscribe" and "result" in message
            return [{**message, "result": {"return_code": "OK"}}] if found else [message]

        async with trying() as url, bent(url, to_application=mislead) as proxy:
            assert await run("--url", proxy.url, "--only", "subscribe") == 1
        shown = capsys.readouterr().out
        assert shown.count("subscribe: A subscriber is notified") == 1
        assert shown.count(" subscribe: as above") == shown.count("FAIL") - 1 > 0

    async def test_one_that_cannot_even_be_looked_at(self, capsys: pytest.CaptureFixture[str]) -> None:
        async with trying() as url, bent(url, to_application=lambda m, _n: [{**m, "time": 1}]) as proxy:
            assert await run("--url", proxy.url) == 1
        assert capsys.readouterr().err.startswith(f"openrois conformance: {proxy.url}: expected the members of")

    async def test_without_an_adapter(self, capsys: pytest.CaptureFixture[str]) -> None:
        async with trying() as url:
            assert await run("--url", url, "--no-adapter", "--only", "event.*") == 0
        shown = capsys.readouterr().out
        assert "partly   event.selection" in shown
        assert "not run  event.notify" in shown
        assert "checks not run: the suite's own adapter was not allowed (--no-adapter)" in shown

    async def test_every_frame(self, capsys: pytest.CaptureFixture[str]) -> None:
        async with trying() as url:
            assert await run("--url", url, "--verbose", "--no-adapter", "--only", "system.connect") == 0
        assert '<- {"jsonrpc":"2.0","id":"req-1","result":{"return_code":"OK"}}' in capsys.readouterr().out

    async def test_no_gateway_is_there(self, capsys: pytest.CaptureFixture[str]) -> None:
        assert await run("--url", "ws://127.0.0.1:9/") == 1
        shown = capsys.readouterr()
        assert shown.out == ""
        assert shown.err.startswith("openrois conformance: ws://127.0.0.1:9/: expected an application to be let in")

    async def test_what_cannot_be_written(self, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
        assert await run("--only", "query.*", "--json", str(tmp_path / "nowhere" / "x.json")) == 1
        assert "No such file" in capsys.readouterr().err


class TestTokens:
    """At a gateway that asks for tokens, over TLS, the same passes as elsewhere."""

    async def test_an_administrator_alone_or_an_operator_with_an_adapter(
        self, capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        given: dict[str, str] = {}

        def shown(name: str, **claims: object) -> str:
            given[name] = fresh(**claims)
            (tmp_path / name).write_text(given[name] + "\n")
            return str(tmp_path / name)

        chief = shown("chief", roles="administrator")
        operator = shown("operator", roles="operator", scope=["conformance-*"])
        adapter = shown("adapter", roles="adapter", scope=["conformance-*"])
        authority = Authority(tmp_path)
        cert, key = authority.issue()
        async with guarded(tmp_path, tls_cert=cert, tls_key=key) as coming:
            part = ("--url", coming.gateway.url, "--only", "extension.[lt]*-*")
            trusting = (*part, "--ca-file", str(authority.file))
            assert await run(*trusting, "--token-file", chief) == 0
            assert "7 passed, 0 failed, 0 tried in part, 0 not run" in capsys.readouterr().out
            run_file = tmp_path / "run.json"
            keeping = ("--token-file", operator, "--adapter-token-file", adapter, "--verbose", "--json", str(run_file))
            assert await run(*trusting, *keeping) == 0
            said = capsys.readouterr().out
            assert "5 passed, 0 failed, 1 tried in part, 1 not run" in said
            assert "what the gateway was shown is no administrator's token" in said
            assert '"token": "(hidden)"' in said
            assert given["operator"] not in said + run_file.read_text()
            assert await run(*trusting, "--token-file", operator) == 0
            assert "the suite's adapter was not taken: 403: the token is not for this" in capsys.readouterr().out
            monkeypatch.setenv(TOKEN_FILE_VARIABLE, operator)
            monkeypatch.setenv(CA_FILE_VARIABLE, str(authority.file))
            assert await run(*part, "--no-adapter") == 0
            monkeypatch.delenv(CA_FILE_VARIABLE)
            assert await run(*part) == 1
            assert "came its certificate is not trusted" in capsys.readouterr().err
            monkeypatch.delenv(TOKEN_FILE_VARIABLE)
            assert await run(*trusting) == 1
            assert "came 401: a valid token is needed" in capsys.readouterr().err


class Mistyped(components.Navigation):
    """Has `strat` where it should have `start`."""

    @adapting.command
    async def strat(self) -> None: ...

    async def stop(self) -> None: ...


async def test_a_component_that_lacks_a_command(capsys: pytest.CaptureFixture[str]) -> None:
    async with deployment.gateway(adapter_timeout=0.5) as gateway, deployment.adapter(gateway, Mistyped("legs")):
        part = ("--url", gateway.url.replace("http", "ws"), "--no-adapter", "--only")
        assert await run(*part, "own.commands", "--component", "robot/legs") == 1
        shown = capsys.readouterr().out
        assert "FAIL     own.commands" in shown
        assert "the commands start of a Navigation" in shown
        assert await run(*part, "standard-profiles") == 0
        assert "note      robot/legs, a Navigation, lacks start" in capsys.readouterr().out


@asynccontextmanager
async def trying() -> AsyncIterator[str]:
    async with deployment.gateway(adapter_timeout=0.5) as gateway:
        yield gateway.url.replace("http", "ws")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--url", "127.0.0.1:8765"], "no address of a gateway"),
        (["--timeout", "0"], "more than 0"),
        (["--url", "ws://x/", "--token-file", "/nowhere"], "the token cannot be read from /nowhere"),
        (["--url", "ws://x/", "--adapter-token-file", "/nowhere"], "the token cannot be read from /nowhere"),
        (["--url", "wss://x/", "--ca-file", "/nowhere"], "/nowhere cannot be used as authorities"),
        (["--url", "ws://x/", "--markdown"], "--markdown prints the manifest"),
        (["--url", "ws://x/", "--component", "a/b", "--component", "a/b"], "--component is given twice"),
    ],
)
def test_wrong_usage_ends_with_2(arguments: list[str], words: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as raised:
        command.main(arguments)
    assert raised.value.code == 2
    assert words in capsys.readouterr().err


def test_nothing_of_that_name(capsys: pytest.CaptureFixture[str]) -> None:
    assert command.main(["--only", "nothing"]) == 2
    assert "nothing is called like 'nothing'" in capsys.readouterr().err


async def test_two_processes(tmp_path: Path) -> None:
    """As a user does it: the gateway's process, and the suite's."""
    program = (sys.executable, "-m", "openrois.cli")
    gateway = await asyncio.create_subprocess_exec(
        *program, "gateway", "--port", "0", "--adapter-timeout", "0.5",
        stdout=asyncio.subprocess.PIPE, stderr=asyncio.subprocess.DEVNULL,
    )  # fmt: skip
    try:
        assert gateway.stdout is not None
        url = (await gateway.stdout.readline()).decode().split()[1].replace("http", "ws")
        suite = await asyncio.create_subprocess_exec(
            *program, "conformance", "--url", url, stdout=asyncio.subprocess.PIPE, stderr=asyncio.subprocess.PIPE
        )
        shown, errors = await suite.communicate()
        assert (suite.returncode, errors) == (0, b""), shown.decode()
        assert b" 0 failed, 0 tried in part, 6 not run" in shown
    finally:
        gateway.terminate()
        await gateway.wait()
