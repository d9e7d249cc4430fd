"""`openrois profile`: profiles out of a real gateway into files, and back into the JSON of the wire."""

import asyncio
import json
import os
import re
import signal
import sys
from collections.abc import AsyncIterator, Callable
from pathlib import Path
from typing import Any

import pytest
from aiohttp import web
from websockets.asyncio.server import ServerConnection, serve

from openrois.catalog.actuation import NAVIGATION
from openrois.catalog.sensing import SPEECH_RECOGNITION
from openrois.gateway.server import Gateway
from openrois.profiles.command import main
from openrois.profiles.query import NoProfile, ask_profiles
from openrois.profiles.xml.parse import MAX_SIZE
from openrois.profiles.xml.write import component_xml, engine_xml
from openrois.types.profiles import HRIEngineProfile, RoISIdentifier
from tests.support.certificates import Authority
from tests.support.demo import free_port
from tests.support.deployment import gateway, until
from tests.support.fleet import everything, fleet
from tests.support.guarded import fresh, guarded
from tests.support.profiles import structural_errors

Run = Callable[..., Any]
FULL = Path("/dev/full")


@pytest.fixture
async def house() -> AsyncIterator[Gateway]:
    """A gateway with one robot that has every component."""
    async with gateway() as running, fleet(address(running) + "adapter", everything()):
        await until(running.engine, lambda ids: "robot" in ids)
        yield running


def address(running: Gateway) -> str:
    return running.url.replace("http", "ws")


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Run:
    """Run the command beside the test's own loop; returns its exit status and what it wrote."""

    async def run(*arguments: object) -> tuple[int, str, str]:
        status = await asyncio.to_thread(main, [str(each) for each in arguments])
        written = capsys.readouterr()
        return status, written.out, written.err

    return run


def answer(running: Gateway) -> dict[str, Any]:
    """What the gateway says of its profiles, as the JSON of the wire."""
    directory = running.engine.directory
    return {
        "profile": directory.profile.model_dump(mode="json"),
        "component_profiles": {ref: each.model_dump(mode="json") for ref, each in directory.component_profiles.items()},
    }


async def openrois(*arguments: object, **environment: str) -> asyncio.subprocess.Process:
    """Start the command as a process of its own."""
    return await asyncio.create_subprocess_exec(
        *(sys.executable, "-m", "openrois.cli", "profile", *map(str, arguments)),
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.PIPE,
        env={**os.environ, **environment},
    )


async def test_as_processes_of_their_own(house: Gateway, tmp_path: Path) -> None:
    async def run(*arguments: object) -> tuple[int | None, str, str]:
        process = await openrois(*arguments)
        out, err = await process.communicate()
        return process.returncode, out.decode(), err.decode()

    system = tmp_path / "system"
    assert await run("export", "--url", address(house), "--output", system) == (0, "", "")
    assert len(list(system.rglob("*.xml"))) == 18
    status, out, err = await run("import", system)
    assert (status, err) == (0, "")
    assert json.loads(out) == answer(house)
    (system / "components" / "robot_x002F_move.xml").write_text("<a>\n</b>")
    status, out, err = await run("import", system)
    assert (status, out) == (1, "")
    assert err.splitlines() == [
        f"openrois profile: {system}/components/robot_x002F_move.xml: line 2: this is no XML: mismatched tag",
        "openrois profile: nothing is imported: 1 of 18 files cannot be used",
    ]


async def test_what_it_prints_is_utf_8_wherever_it_goes(tmp_path: Path) -> None:
    profile = component_xml(NAVIGATION.profile("乗り物"), "robot/legs")
    file = tmp_path / "legs.xml"
    file.write_text(profile, encoding="utf-8")
    process = await openrois("import", file, PYTHONIOENCODING="ascii")
    out, err = await process.communicate()
    assert (process.returncode, err) == (0, b"")
    assert json.loads(out)["name"] == "乗り物"


async def test_a_reader_that_goes_away_is_no_error() -> None:
    reader, writer = os.pipe()
    os.close(reader)
    process = await asyncio.create_subprocess_exec(
        *(sys.executable, "-m", "openrois.cli", "profile", "export", "--type", "Navigation"),
        stdout=writer,
        stderr=asyncio.subprocess.PIPE,
    )
    os.close(writer)
    assert (await process.communicate())[1] == b""
    assert process.returncode == 0


class TestExport:
    async def test_everything_as_xml_and_back(self, house: Gateway, run: Run, tmp_path: Path) -> None:
        system = tmp_path / "system"
        assert await run("export", "--url", address(house), "--output", system) == (0, "", "")
        files = sorted(system.rglob("*.xml"))
        assert [structural_errors(file.read_text()) for file in files] == [[]] * 18
        status, out, err = await run("import", *files)
        assert (status, json.loads(out), err) == (0, answer(house), "")

    async def test_the_engine_alone(self, house: Gateway, run: Run) -> None:
        status, out, err = await run("export", "--url", address(house))
        assert (status, out) == (0, engine_xml(house.engine.directory.profile))
        assert err == (
            "openrois profile: this is the engine's profile; --output DIRECTORY writes those of its 17 components too\n"
        )

    async def test_everything_as_json(self, house: Gateway, run: Run, tmp_path: Path) -> None:
        status, out, err = await run("export", "--url", address(house), "--format", "json")
        assert (status, json.loads(out), err) == (0, answer(house), "")
        file = tmp_path / "system.json"
        assert await run("export", "--url", address(house), "--format", "json", "--output", file) == (0, "", "")
        assert file.read_text() == out
        assert await run("import", file) == (0, out, "")

    async def test_one_component(self, house: Gateway, run: Run) -> None:
        chosen = ("export", "--url", address(house), "--component", "robot/navigation")
        assert await run(*chosen) == (0, component_xml(NAVIGATION.profile(), "robot/navigation"), "")
        status, out, _ = await run(*chosen, "--format", "json")
        assert (status, json.loads(out)) == (0, NAVIGATION.profile().model_dump(mode="json"))

    async def test_a_component_that_is_not_there(self, house: Gateway, run: Run) -> None:
        status, out, err = await run("export", "--url", address(house), "--component", "it's")
        assert (status, out) == (1, "")
        assert err == f'openrois profile: there is no component "it\'s" at {address(house)}\n'

    async def test_a_type_needs_no_gateway(self, run: Run, tmp_path: Path) -> None:
        definition = NAVIGATION.definition()
        assert await run("export", "--type", "Navigation") == (0, component_xml(definition), "")
        file = tmp_path / "navigation.json"
        assert await run("export", "--type", "Navigation", "--format", "json", "--output", file) == (0, "", "")
        assert json.loads(file.read_text()) == definition.model_dump(mode="json")

    async def test_a_gateway_without_anything(self, run: Run) -> None:
        async with gateway() as running:
            status, out, err = await run("export", "--url", address(running))
        assert (status, err) == (0, "")
        assert "<rois:HRIComponent>none.gateway</rois:HRIComponent>" in out

    async def test_a_directory_that_is_in_use_is_left_alone(self, house: Gateway, run: Run, tmp_path: Path) -> None:
        (tmp_path / "old.xml").touch()
        status, _, err = await run("export", "--url", address(house), "--output", tmp_path)
        assert (status, err) == (1, f"openrois profile: the directory '{tmp_path}' is not empty\n")
        assert [each.name for each in tmp_path.iterdir()] == ["old.xml"]  # noqa: ASYNC240

    async def test_a_file_that_cannot_be_written(self, run: Run, tmp_path: Path) -> None:
        missing = tmp_path / "missing" / "navigation.xml"
        status, _, err = await run("export", "--type", "Navigation", "--output", missing)
        assert (status, err) == (1, f"openrois profile: {missing}: No such file or directory\n")


class TestNoGateway:
    async def test_a_port_that_is_none(self, run: Run) -> None:
        status, _, err = await run("export", "--url", "ws://127.0.0.1:99999/")
        sentence = "'ws://127.0.0.1:99999/' is no address of a gateway, such as ws://127.0.0.1:8765/"
        assert (status, err) == (1, f"openrois profile: {sentence}\n")

    async def test_an_interrupt_ends_it(self) -> None:
        async def keep_silent(connection: ServerConnection) -> None:
            await connection.recv()
            process.send_signal(signal.SIGINT)
            await connection.wait_closed()

        async with serve(keep_silent, "127.0.0.1", 0) as server:
            url = f"ws://127.0.0.1:{next(iter(server.sockets)).getsockname()[1]}/"
            process = await openrois("export", "--url", url)
            assert await process.communicate() == (b"", b"")
        assert process.returncode == 130

    async def test_no_gateway_listens(self, run: Run) -> None:
        url = f"ws://127.0.0.1:{free_port()}/"
        status, out, err = await run("export", "--url", url)
        assert (status, out, err.count("\n")) == (1, "", 1)
        assert err.startswith(f"openrois profile: no gateway answers at {url}; `openrois gateway` starts one here (")

    async def test_no_such_host(self, run: Run) -> None:
        status, _, err = await run("export", "--url", "ws://host.invalid/")
        assert (status, err.count("\n")) == (1, 1)
        assert err.startswith("openrois profile: no gateway answers at ws://host.invalid/; ")

    async def test_no_address(self, run: Run) -> None:
        status, _, err = await run("export", "--url", "localhost:8765")
        sentence = "openrois profile: 'localhost:8765' is no address of a gateway, such as ws://127.0.0.1:8765/\n"
        assert (status, err) == (1, sentence)

    async def test_a_web_server(self, run: Run) -> None:
        runner = web.AppRunner(web.Application())
        await runner.setup()
        await web.TCPSite(runner, "127.0.0.1", 0).start()
        url = f"ws://127.0.0.1:{runner.addresses[0][1]}/"
        status, _, err = await run("export", "--url", url)
        await runner.cleanup()
        assert status == 1
        assert err.startswith(f"openrois profile: {url} answered 404: ")

    async def test_a_gateway_that_asks_for_a_token_over_tls(self, run: Run, tmp_path: Path) -> None:
        authority, token = Authority(tmp_path), tmp_path / "token"
        token.write_text(fresh(roles="viewer"))
        cert, key = authority.issue()
        async with guarded(tmp_path, tls_cert=cert, tls_key=key) as coming:
            url = coming.gateway.url
            chosen = ("export", "--url", url, "--ca-file", authority.file)
            status, out, _ = await run(*chosen, "--token-file", token)
            assert (status, out) == (0, engine_xml(coming.gateway.engine.directory.profile))
            _, _, err = await run(*chosen)
            assert err == f"openrois profile: {url} answered 401: a valid token is needed (--token-file)\n"
            status, _, err = await run("export", "--url", url, "--token-file", token)
            assert (status, err.count("\n")) == (1, 1)
            assert err.startswith(f"openrois profile: no gateway is reached at {url}: its certificate is not trusted: ")

    @pytest.mark.parametrize(
        ("result", "sentence"),
        [
            ({"return_code": "ERROR"}, "{url} answers ERROR and no profile"),
            (
                {"profile": {"identifier": {}}},
                "{url} answers with a malformed profile: profile.identifier.code: Field",
            ),
            ([], "{url} answers with a malformed profile: Input should be a valid dictionary"),
            ({"return_code": "OK"}, "the gateway has no profile of its own"),
            (None, "what answers at {url} is no gateway: "),
        ],
    )
    async def test_what_answers_is_none(self, result: Any, sentence: str, run: Run) -> None:
        async def behave(connection: ServerConnection) -> None:
            async for text in connection:
                request = json.loads(text)
                if result is None:
                    await connection.close()
                    return
                outcome = result if request["method"] == "rois.system.get_profile" else {"return_code": "OK"}
                await connection.send(json.dumps({"jsonrpc": "2.0", "id": request["id"], "result": outcome}))

        async with serve(behave, "127.0.0.1", 0) as server:
            url = f"ws://127.0.0.1:{next(iter(server.sockets)).getsockname()[1]}/"
            status, out, err = await run("export", "--url", url)
        assert (status, out) == (1, "")
        assert err.startswith("openrois profile: " + sentence.format(url=url))

    async def test_a_silent_server(self) -> None:
        async def keep_silent(connection: ServerConnection) -> None:
            await connection.wait_closed()

        async with serve(keep_silent, "127.0.0.1", 0) as server:
            url = f"ws://127.0.0.1:{next(iter(server.sockets)).getsockname()[1]}/"
            with pytest.raises(NoProfile, match=f"^{url} does not answer in time$"):
                await ask_profiles(url, timeout=0.01)


class TestImport:
    async def test_types(self, run: Run, tmp_path: Path) -> None:
        definitions = [NAVIGATION.definition(), SPEECH_RECOGNITION.definition()]
        files = [tmp_path / "navigation.xml", tmp_path / "speech.json"]
        files[0].write_text(component_xml(definitions[0]))
        files[1].write_text(definitions[1].model_dump_json())
        plain = [each.model_dump(mode="json") for each in definitions]
        assert [json.loads((await run("import", file))[1]) for file in files] == plain
        target = tmp_path / "types.json"
        assert await run("import", *files, "--output", target) == (0, "", "")
        assert json.loads(target.read_text()) == plain
        assert json.loads((await run("import", target))[1]) == plain

    async def test_remarks_and_doubts_are_said(self, run: Run, tmp_path: Path) -> None:
        file = tmp_path / "speech.xml"
        text = component_xml(SPEECH_RECOGNITION.definition()).replace("[&quot;ja&quot;]", "jp")
        file.write_text(text.replace("<gml:name>", "<gml:name>recognizer</gml:name><gml:name>", 1))
        status, out, err = await run("import", file)
        assert (status, json.loads(out)["name"]) == (0, "recognizer")
        assert err.splitlines() == [
            f"openrois profile: {file}: line 4: the name 'speech_recognizer' is left out: there is another",
            "openrois profile: recognizer: the default of 'languages': 'jp' is not a JSON array",
        ]

    async def test_an_engine_in_json(self, run: Run, tmp_path: Path) -> None:
        profile = HRIEngineProfile(identifier=RoISIdentifier(code="robot"), component_ids=("robot/legs",))
        file = tmp_path / "engine.json"
        file.write_text("\ufeff  " + profile.model_dump_json())
        status, out, err = await run("import", file)
        assert (status, err) == (0, "")
        assert json.loads(out) == {"profile": profile.model_dump(mode="json"), "component_profiles": {}}

    async def test_components_without_their_engine(self, run: Run, tmp_path: Path) -> None:
        profile = NAVIGATION.profile().model_dump(mode="json")
        system = {"profile": None, "component_profiles": {"robot/legs": profile, "robot/wheels": profile}}
        file = tmp_path / "components.json"
        file.write_text(json.dumps(system))
        status, out, err = await run("import", file)
        assert (status, json.loads(out), err) == (0, system, "")

    async def test_a_type_among_components(self, run: Run, tmp_path: Path) -> None:
        (tmp_path / "a.xml").write_text(component_xml(NAVIGATION.definition()))
        (tmp_path / "b.xml").write_text(component_xml(NAVIGATION.profile(), "robot/legs"))
        status, _, err = await run("import", tmp_path)
        assert status == 1
        sentence = "the profile of 'navigation' is that of a type: its gml:id does not say whose it is"
        assert err == f"openrois profile: {sentence}\n"

    async def test_two_profiles_of_one_component(self, run: Run, tmp_path: Path) -> None:
        for name in ("a.xml", "b.XML"):
            (tmp_path / name).write_text(component_xml(NAVIGATION.profile(), "robot/legs"))
        assert (await run("import", tmp_path))[2] == "openrois profile: the component 'robot/legs' has two profiles\n"

    @pytest.mark.parametrize(
        ("content", "sentence"),
        [
            (b"", "line 1: this is no XML: no element found"),
            (b"<a/>", "line 1: a is no profile: rois:HRIEngineProfile or rois:HRIComponentProfile is expected"),
            (b'{"name": "x",\n]', "line 2: this is no JSON: "),
            (b'{"name": "x"}', "identifier: Field required"),
            (b'[{"name": "x"}]', "0.identifier: Field required"),
            (b"[5]", "0: Input should be a valid dictionary"),
            (b"{}", "identifier: Field required"),
            (b'{"profile": null, "mood": 1}', "mood: Extra inputs are not permitted"),
            (b'{"name": "\xff"}', "this is no JSON: the text is not UTF-8"),
            (b"[]", "there is no profile in it"),
            (b'{"profile": null}', "there is no profile in it"),
            (b'[{"name": "x", "identifier": {"code": "x"}}, 5]', "1: Input should be a valid dictionary"),
            (b'{"timeout": ' + b"9" * 5000 + b"}", "a number in it has too many digits"),
            (b"[" * 100_000, "this is nested too deeply for a profile"),
            (b" [" + b" " * MAX_SIZE, f"the file has more than {MAX_SIZE} bytes"),
            (b"<a>" + b" " * MAX_SIZE, f"line 1: the document has more than {MAX_SIZE} bytes"),
        ],
    )
    async def test_files_that_are_no_profiles(self, content: bytes, sentence: str, run: Run, tmp_path: Path) -> None:
        file = tmp_path / "file"
        file.write_bytes(content)
        status, out, err = await run("import", file)
        assert (status, out) == (1, "")
        first, second = err.splitlines()
        assert first.startswith(f"openrois profile: {file}: {sentence}")
        assert second == "openrois profile: nothing is imported"

    async def test_half_a_surrogate_pair_is_printed_as_json_writes_it(self, run: Run, tmp_path: Path) -> None:
        file = tmp_path / "lamp.json"
        file.write_text('{"identifier": {"code": "x"}, "name": "\\ud800"}')
        status, out, err = await run("import", file)
        assert (status, json.loads(out)["name"], err) == (0, "\ud800", "")

    async def test_a_long_way_to_what_is_wrong_is_told_by_its_end(self, run: Run, tmp_path: Path) -> None:
        engine: dict[str, Any] = {"identifier": {"code": 5}}
        for _ in range(50):
            engine = {"identifier": {"code": "x"}, "sub_profiles": [engine]}
        file = tmp_path / "engine.json"
        file.write_text(json.dumps(engine))
        status, _, err = await run("import", file)
        assert status == 1
        assert err.splitlines()[0].endswith(".sub_profiles.0.identifier.code: Input should be a valid string")
        assert len(err) < 400

    @pytest.mark.skipif(not FULL.exists(), reason="this system has no device that is always full")
    async def test_a_full_disk(self, run: Run) -> None:
        status, _, err = await run("export", "--type", "Navigation", "--output", FULL)
        assert (status, err) == (1, "openrois profile: No space left on device\n")

    async def test_files_that_are_not_there(self, run: Run, tmp_path: Path) -> None:
        status, _, err = await run("import", tmp_path / "a", tmp_path / "b")
        assert status == 1
        assert err.splitlines() == [
            f"openrois profile: {tmp_path}/a: No such file or directory",
            f"openrois profile: {tmp_path}/b: No such file or directory",
            "openrois profile: nothing is imported: 2 of 2 files cannot be used",
        ]

    async def test_a_directory_without_profiles(self, run: Run, tmp_path: Path) -> None:
        (tmp_path / "notes.txt").touch()
        (tmp_path / "folder.xml").mkdir()
        sentence = f"openrois profile: there is no XML or JSON file in '{tmp_path}'\n"
        assert await run("import", tmp_path) == (1, "", sentence)


@pytest.mark.parametrize(
    "arguments",
    [
        [],
        ["copy"],
        ["import"],
        ["export", "--type", "Dancing"],
        ["export", "--type", "Move", "--component", "a/b"],
        ["export", "--format", "yaml"],
    ],
)
def test_wrong_usage_ends_with_2(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as raised:
        main(arguments)
    assert raised.value.code == 2
    assert re.fullmatch(r"openrois profile[a-z ]*: .*\n", capsys.readouterr().err)
