"""Every limit in wire.md and adapter-wire.md: its number is the constant's, and a test goes there and beyond."""

import asyncio
import re
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack
from pathlib import Path
from typing import Any

import pytest
from openrois_signaling import messages as signaling
from openrois_signaling import relay
from openrois_streaming.input import reader
from openrois_streaming.input.messages import MESSAGE_LIMIT

from openrois.adapter import dialer
from openrois.aio import bounded_history
from openrois.commands import history, quota
from openrois.engine import condition, engine, faults, registry
from openrois.engine.registry import LocalRegistry
from openrois.errors import OutOfResources
from openrois.gateway import adapters, applications, connection_limits
from openrois.gateway.settings import GatewaySettings
from openrois.gateway.socket import ADAPTER, APPLICATION
from openrois.http_limits import websocket_frames
from openrois.interfaces import command, stream
from openrois.jsonrpc import calls, handler, outbox, request_queue, session
from openrois.session import change_notice, events
from openrois.session.session import EngineHost
from openrois.transport import websocket
from openrois.types import access, messages, references, streams, values
from tests.support import deployment, wire
from tests.support.components import Bell, Lamp
from tests.support.deployment import Door
from tests.support.session import settle

ROOT = Path(__file__).parents[2]
KIB, MIB = 1024, 1024 * 1024
DOOR = "robot/door"

HERE = "tests/conformance/test_limits.py"
AUTH = "tests/openrois/auth"
TRANSPORT = "tests/conformance/test_transport.py"
CONNECTION_LIMITS = "tests/openrois/gateway/test_connection_limits.py"
FLOOD = "tests/conformance/test_flood.py"
INTAKE = "tests/openrois/jsonrpc/test_request_queue.py"

LIMITS: dict[str, tuple[tuple[float, ...], tuple[str, ...]]] = {
    "applications at a gateway at a time": (
        (connection_limits.MAX_APPLICATIONS, 503),
        (f"{TRANSPORT}::test_only_so_many_at_a_time",),
    ),
    "applications from one address (`--per-address`)": (
        (connection_limits.MAX_PER_ADDRESS, 429),
        (f"{CONNECTION_LIMITS}::test_one_address_has_so_many",),
    ),
    "token": ((access.MAX_TOKEN,), (f"{AUTH}/test_tokens.py::test_forged_tokens",)),
    "message from an application": (
        (APPLICATION.max_message / KIB, 1009, 1003),
        (f"{TRANSPORT}::test_the_limit_is_exact", f"{TRANSPORT}::test_binary_frames_are_refused"),
    ),
    "frames of one message; pings and pongs to the gateway": (
        (
            websocket_frames.MAX_FRAGMENTS,
            websocket_frames.CONTROL_FRAMES_AT_ONCE,
            websocket_frames.CONTROL_FRAMES_PER_SECOND,
            1008,
        ),
        (
            "tests/openrois/http_limits/test_websocket_frames.py::test_a_message_has_so_many_fragments",
            "tests/openrois/http_limits/test_websocket_frames.py::test_there_may_be_so_many_pings_and_pongs",
        ),
    ),
    "pings to applications": (
        (APPLICATION.ping_interval, APPLICATION.ping_timeout),
        (f"{TRANSPORT}::test_a_silent_side_is_cut", f"{TRANSPORT}::test_the_default_bounds"),
    ),
    "messages waiting to be sent on one connection, events aside": (
        (outbox.CONTROL_LIMIT, outbox.CONTROL_TEXT / MIB),
        (
            f"{HERE}::test_messages_that_wait",
            f"{TRANSPORT}::test_is_cut_off_and_costs_no_other_anything",
            "tests/openrois/jsonrpc/test_outbox.py::test_text_is_bounded_too",
            "tests/conformance/test_command.py::test_their_adapter_stays_however_many_start_at_once",
        ),
    ),
    "`notify_event` and `notify_error` waiting on one connection": (
        (outbox.EVENT_LIMIT, outbox.EVENT_TEXT / MIB),
        (
            "tests/openrois/jsonrpc/test_outbox.py::test_text_is_bounded_too",
            "tests/conformance/test_event.py::test_after_hello_the_number_of_dropped_events_is_notified",
            f"{TRANSPORT}::test_loses_events_and_delays_no_other",
        ),
    ),
    "requests of one connection that run at a time": (
        (request_queue.MAX_RUNNING_REQUESTS,),
        (
            f"{HERE}::test_requests_that_run",
            f"{TRANSPORT}::test_one_whose_answers_wait_behind_its_own_requests_stays",
        ),
    ),
    "requests of one connection that wait; characters of them all": (
        (request_queue.MAX_WAITING_REQUESTS, request_queue.MAX_WAITING_TEXT / MIB),
        (
            f"{FLOOD}::test_requests_that_wait_are_bounded",
            f"{INTAKE}::test_those_that_wait_are_bounded_by_their_text_too",
        ),
    ),
    "requests of one application": (
        (applications.REQUESTS_PER_SECOND, applications.REQUESTS_AT_ONCE),
        (f"{FLOOD}::test_a_flood_is_refused_with_retry_after",),
    ),
    "commands of one application, running / finished and remembered": (
        (history.MAX_RUNNING, history.MAX_FINISHED),
        (f"{HERE}::test_commands_that_run", f"{HERE}::test_finished_commands"),
    ),
    "commands `stop` of one application beyond these limits": (
        (history.STOP_RESERVE,),
        (f"{FLOOD}::test_a_stop_is_accepted_when_no_other_command_is",),
    ),
    "components that one application has bound": ((command.MAX_BOUND,), (f"{HERE}::test_bound_components",)),
    "subscriptions of one application; remembered events": (
        (events.MAX_SUBSCRIPTIONS, events.MAX_DETAILS, events.DETAIL_LIFETIME),
        (
            f"{HERE}::test_subscriptions",
            f"{HERE}::test_remembered_events",
            "tests/openrois/session/test_events.py::test_details_are_kept_for_a_while",
        ),
    ),
    "items in a command sequence; characters of a `command_id` / a condition": (
        (messages.MAX_ITEMS, 32602, history.MAX_ID, condition.MAX_LENGTH),
        (
            f"{HERE}::test_items_of_a_sequence",
            f"{HERE}::test_characters_of_a_command_id",
            f"{HERE}::test_characters_of_a_condition",
        ),
    ),
    "a `delay_time`": (
        (0, messages.MAX_DELAY, 32602),
        ("tests/conformance/test_corners.py::test_a_delay_is_a_whole_number_from_zero_to_a_day",),
    ),
    "digits of an integer in a value; depth of a list in it": (
        (values.MAX_DIGITS, values.MAX_DEPTH),
        (f"{HERE}::test_digits_and_depth",),
    ),
    "extensions in `openrois.hello`; parameters of `connect_stream`": (
        (streams.MAX_EXTENSIONS, streams.MAX_PARAMETERS, 32602),
        (f"{HERE}::test_lists_of_extensions",),
    ),
    "`profile_changed` to one application": (
        (change_notice.CHANGES_AT_ONCE, change_notice.CHANGES_PER_SECOND),
        ("tests/openrois/session/test_change_notice.py::test_a_flood_is_cut_and_its_last_is_told",),
    ),
    "streams of one application; sections of one peer": (
        (stream.MAX_STREAMS, signaling.SECTIONS_LIMIT),
        (
            "tests/conformance/test_streams.py::test_only_so_many_even_at_once",
            "tests/media/test_streaming_interface.py::test_the_number_of_applications_and_sections_is_bounded",
        ),
    ),
    "reports of playout of one application; milliseconds in one": (
        (stream.REPORTS_PER_SECOND, stream.REPORTS_AT_ONCE, streams.MAX_PLAYOUT, 32602),
        ("tests/conformance/test_streams.py::test_playout_is_reported_by_the_owner_and_not_too_often",),
    ),
    "signaling of one application": (
        (relay.RATE, relay.BURST, relay.PEERS_PER_OWNER),
        (
            "tests/conformance/test_signaling.py::test_candidates_and_messages_are_bounded",
            "tests/conformance/test_signaling.py::test_an_application_that_reconnects_for_ever_keeps_its_share",
            "tests/conformance/test_stream_ends.py::test_an_adapter_that_comes_and_goes_for_ever",
        ),
    ),
    "session description / candidate": (
        (signaling.SDP_LIMIT / KIB, signaling.CANDIDATE_LIMIT),
        ("tests/conformance/test_signaling.py::test_sizes_and_shapes",),
    ),
    "candidates of one peer": (
        (signaling.CANDIDATES_LIMIT,),
        ("tests/conformance/test_signaling.py::test_candidates_and_messages_are_bounded",),
    ),
    "input of one application: messages; bytes of one; unreadable ones": (
        (reader.PER_SECOND, reader.AT_ONCE, MESSAGE_LIMIT, reader.MALFORMED_LIMIT),
        (
            "tests/streaming/input/test_reader.py::test_too_many_are_counted",
            "tests/streaming/input/test_reader.py::test_binary_or_too_long_messages_are_malformed",
            "tests/body/teleoperation/test_operator_control.py::test_who_sends_nonsense_is_cut_and_told",
        ),
    ),
}
"""Each row of the table of applications: its numbers in order, as units say, and the tests that hit them."""

ADAPTER_LIMITS: dict[str, tuple[tuple[float, ...], tuple[str, ...]]] = {
    "adapters at a gateway at a time": (
        (connection_limits.MAX_ADAPTERS, 503),
        (f"{CONNECTION_LIMITS}::test_adapters_have_places_of_their_own",),
    ),
    "message from an adapter": (
        (ADAPTER.max_message / MIB, 1009, 1003),
        (f"{TRANSPORT}::test_an_adapter_may_say_more",),
    ),
    "message that an adapter takes from its gateway": (
        (websocket.MAX_MESSAGE / MIB,),
        ("tests/openrois/transport/test_websocket.py::test_a_message_may_be_so_long",),
    ),
    "pings to adapters": (
        (ADAPTER.ping_interval, ADAPTER.ping_timeout),
        (f"{TRANSPORT}::test_a_silent_side_is_cut", f"{TRANSPORT}::test_the_default_bounds"),
    ),
    "silence after which what comes may have waited on the way since the gateway gave the adapter up": (
        (dialer._DOUBT,),
        (
            "tests/openrois/transport/test_websocket.py::test_what_has_waited_on_the_way_is_not_taken_from_a_side_that_has_left",
        ),
    ),
    "messages waiting for one adapter, events aside": (
        (outbox.CONTROL_LIMIT, outbox.CONTROL_TEXT / MIB),
        ("tests/conformance/test_command.py::test_their_adapter_stays_however_many_start_at_once",),
    ),
    "characters of an engine's id, and of a component's name": (
        (references.MAX_ID,),
        ("tests/openrois/types/test_references.py::test_what_cannot_name_an_engine",),
    ),
    "depth of the tree of engines": (
        (engine.MAX_DEPTH, 1008),
        (
            "tests/openrois/engine/test_engine.py::test_engines_stand_only_so_deep",
            "tests/conformance/test_adapters.py::test_what_is_not_acceptable_is_closed_with_the_reason",
        ),
    ),
    "queries of one component that run at a time in its adapter; how long one may take there": (
        (registry.MAX_QUERIES, registry.QUERY_TIMEOUT),
        (
            "tests/openrois/engine/test_registry.py::test_only_so_many_queries_at_a_time",
            "tests/openrois/engine/test_registry.py::test_a_query_ends",
            "tests/conformance/test_query.py::test_a_component_that_hangs_blocks_no_other",
        ),
    ),
    "answer of an adapter": (
        (session.CALL_TIMEOUT,),
        ("tests/conformance/test_adapters.py::test_one_that_does_not_answer", f"{HERE}::test_the_time_for_an_answer"),
    ),
    "answers of an adapter that come too late and still matter": (
        (calls.MAX_LATE,),
        ("tests/openrois/jsonrpc/test_session_calls.py::test_late_answers_are_remembered_within_a_bound",),
    ),
    "reads of the profile of one adapter that says `profile_changed`": (
        (1 / adapters.CHANGE_PAUSE,),
        ("tests/conformance/test_adapters.py::test_many_changes_at_once_are_two",),
    ),
    "faults of one engine that are notified": (
        (faults.FAULTS_AT_ONCE, faults.FAULTS_PER_SECOND),
        (
            "tests/conformance/test_errors.py::test_a_flood_is_cut",
            "tests/openrois/engine/test_faults.py::test_a_flood_is_cut",
        ),
    ),
    "characters of a fault's description": (
        (faults.MAX_DESCRIPTION,),
        ("tests/openrois/engine/test_faults.py::test_a_long_description_is_cut",),
    ),
}
"""Each row of the table of adapters."""

ALL: dict[str, tuple[tuple[float, ...], tuple[str, ...]]] = LIMITS | ADAPTER_LIMITS


def rows(page: str) -> dict[str, str]:
    """Return the table of a page: what is limited, and the text that says how."""
    text = (ROOT / "docs/reference" / page).read_text(encoding="utf-8").partition("\n## Limits\n")[2]
    found = re.findall(r"^\| (.+?) \| (.+) \|$", text, re.MULTILINE)
    return dict(found[1:])


class TestTable:
    @pytest.mark.parametrize(("page", "limits"), [("wire.md", LIMITS), ("adapter-wire.md", ADAPTER_LIMITS)])
    def test_every_limit_is_named_here_and_there(self, page: str, limits: dict[str, Any]) -> None:
        assert list(rows(page)) == list(limits)

    @pytest.mark.parametrize("row", ALL)
    def test_the_numbers_are_the_constants(self, row: str) -> None:
        text = (rows("wire.md") | rows("adapter-wire.md"))[row]
        said = [float(number.replace(",", "")) for number in re.findall(r"\d[\d,]*(?:\.\d+)?", text)]
        assert said == [float(number) for number in ALL[row][0]]

    @pytest.mark.parametrize("row", ALL)
    def test_tests_hit_them(self, row: str) -> None:
        for reference in ALL[row][1]:
            path, _, name = reference.partition("::")
            text = (ROOT / path).read_text(encoding="utf-8")
            assert re.search(rf"def {name}\(", text), f"there is no {reference}"


@pytest.fixture
async def door() -> Door:
    return Door()


@pytest.fixture
async def bell() -> Bell:
    return Bell()


@pytest.fixture
async def host(door: Door, bell: Bell) -> AsyncIterator[EngineHost]:
    top = engine.Engine("gateway")
    await top.attach(LocalRegistry("robot", [door, bell]))
    async with wire.hosted(top) as made:
        yield made


@pytest.fixture
async def app(host: EngineHost) -> AsyncIterator[wire.Application]:
    async with wire.application(host) as connected:
        yield connected


def sequence(first: int, count: int, how: str = "") -> list[dict[str, Any]]:
    arguments = [{"name": "how", "data_type_ref": "string", "value": how}] if how else []
    unit = {"component_ref": DOOR, "command_type": "open", "arguments": arguments}
    return [{**unit, "command_id": str(number)} for number in range(first, first + count)]


async def execute(app: wire.Application, units: list[dict[str, Any]]) -> str:
    return str((await app.ask("rois.command.execute", command_unit_list=units))["return_code"])


class TestCommands:
    async def test_commands_that_run(self, app: wire.Application, door: Door) -> None:
        door.may_answer.clear()
        for first in range(0, history.MAX_RUNNING, messages.MAX_ITEMS):
            assert await execute(app, sequence(first, messages.MAX_ITEMS)) == "OK"
        assert await execute(app, sequence(history.MAX_RUNNING, 1)) == "OUT_OF_RESOURCES"
        answer = await app.ask("rois.command.set_parameter", component_ref=DOOR, parameters=[])
        assert answer["return_code"] == "UNSUPPORTED"
        door.may_answer.set()
        for _ in range(history.MAX_RUNNING):
            await app.next("rois.command.completed")
        assert await execute(app, sequence(history.MAX_RUNNING, 1)) == "OK"

    async def test_finished_commands(self, app: wire.Application) -> None:
        for first in range(0, history.MAX_FINISHED + messages.MAX_ITEMS, messages.MAX_ITEMS):
            assert await execute(app, sequence(first, messages.MAX_ITEMS)) == "OK"
            for _ in range(messages.MAX_ITEMS):
                await app.next("rois.command.completed")
        for command_id, code in (
            (messages.MAX_ITEMS - 1, "BAD_PARAMETER"),
            (messages.MAX_ITEMS, "OK"),
            (messages.MAX_ITEMS + history.MAX_FINISHED - 1, "OK"),
        ):
            answer = await app.ask("rois.command.get_command_result", command_id=str(command_id))
            assert (command_id, answer["return_code"]) == (command_id, code)

    async def test_text_of_commands(self, app: wire.Application) -> None:
        how = "x" * (MIB // 2 - KIB)
        count = bounded_history.MAX_TEXT // (MIB // 2) + 1
        for number in range(count):
            assert await execute(app, sequence(number, 1, how)) == "OK"
            await app.next("rois.command.completed")
        for command_id, code in ((0, "BAD_PARAMETER"), (1, "OK"), (count - 1, "OK")):
            answer = await app.ask("rois.command.get_command_result", command_id=str(command_id))
            assert (command_id, answer["return_code"]) == (command_id, code)

    async def test_unfinished_commands_of_all(self) -> None:
        budget, own = quota.CommandQuota(), quota.Allowance("one application", 100_000, 0)
        taken = budget.accept_commands(own, quota.MAX_UNFINISHED)
        with pytest.raises(OutOfResources, match="the engine has at most 16384 unfinished commands"):
            budget.accept_commands(own, 1)
        taken.end_one()
        budget.accept_commands(own, 1)

    async def test_text_of_unfinished_commands_of_all(self) -> None:
        most = quota.MAX_UNFINISHED_TEXT
        budget, own = quota.CommandQuota(), quota.Allowance("one application", 10, 2 * most)
        taken = budget.accept_commands(own, 2, most)
        for _ in range(2):
            with pytest.raises(OutOfResources, match=f"at most {most} bytes .* of the engine"):
                budget.accept_commands(own, 1, 1)
            taken.end_one()
        budget.accept_commands(own, 1, most)

    async def test_text_of_commands_that_run(self, app: wire.Application, host: EngineHost, door: Door) -> None:
        door.may_answer.clear()
        how = "x" * (MIB - 2 * KIB)
        count = history.MAX_RUNNING_TEXT // MIB
        for number in range(count):
            assert await execute(app, sequence(number, 1, how)) == "OK"
        assert await execute(app, sequence(count, 1, how)) == "OUT_OF_RESOURCES"
        assert history.MAX_RUNNING_TEXT - MIB < host.commands.text <= history.MAX_RUNNING_TEXT
        assert await execute(app, sequence(count, 1)) == "OK"
        door.may_answer.set()
        for _ in range(count + 1):
            await app.next("rois.command.completed")
        assert (host.commands.taken, host.commands.text) == (0, 0)
        assert await execute(app, sequence(count + 1, 1, how)) == "OK"

    async def test_those_of_applications_that_are_gone_count(self, host: EngineHost, door: Door) -> None:
        """So work cannot be piled up by reconnecting again and again."""
        host.commands = quota.CommandQuota(most=4)
        door.may_answer.clear()
        for _ in range(2):
            async with wire.application(host) as leaving:
                assert await execute(leaving, sequence(0, 2)) == "OK"
        async with wire.application(host) as app:
            assert await execute(app, sequence(0, 1)) == "OUT_OF_RESOURCES"
            door.may_answer.set()
            async with deployment.patience():
                while len(door.opened) < 4:
                    await app.ask("rois.system.connect")
            assert await execute(app, sequence(0, 4)) == "OK"

    async def test_items_of_a_sequence(self, app: wire.Application) -> None:
        assert await execute(app, sequence(0, messages.MAX_ITEMS)) == "OK"
        with pytest.raises(session.RpcError) as refused:
            await execute(app, sequence(0, messages.MAX_ITEMS + 1))
        assert refused.value.code == -32602

    async def test_bound_components(self, app: wire.Application, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(command, "MAX_BOUND", 1)
        for ref, code in ((DOOR, "OK"), (DOOR, "OK"), ("robot/bell", "OUT_OF_RESOURCES")):
            assert (await app.ask("rois.command.bind", component_ref=ref))["return_code"] == code
        assert (await app.ask("rois.command.release", component_ref=DOOR))["return_code"] == "OK"
        assert (await app.ask("rois.command.bind", component_ref="robot/bell"))["return_code"] == "OK"

    async def test_requested_components_count_as_bound(
        self, monkeypatch: pytest.MonkeyPatch, stack: AsyncExitStack
    ) -> None:
        monkeypatch.setattr(command, "MAX_BOUND", 1)
        gateway = await stack.enter_async_context(deployment.gateway())
        await stack.enter_async_context(deployment.adapter(gateway, Lamp(), Lamp("other"), Lamp("third")))
        ann = await stack.enter_async_context(deployment.application(gateway))
        bob = await stack.enter_async_context(deployment.application(gateway))
        assert await bob.code("rois.command.bind", component_ref="robot/third") == "OK"
        for way in ("openrois.lease.request", "openrois.lease.take"):
            assert await ann.code(way, component_ref="robot/lamp") == "OK"
            assert await ann.code(way, component_ref="robot/lamp") == "OK"
            for ref in ("robot/other", "robot/third"):
                assert await ann.code(way, component_ref=ref) == "OUT_OF_RESOURCES"
            assert await ann.code("rois.command.release", component_ref="robot/lamp") == "OK"
        # A request is answered sooner or later.
        assert await ann.code("openrois.lease.request", component_ref="robot/third") == "OK"
        assert await ann.code("openrois.lease.request", component_ref="robot/lamp") == "OUT_OF_RESOURCES"

    async def test_characters_of_a_command_id(self, app: wire.Application) -> None:
        for length, code in ((history.MAX_ID, "OK"), (history.MAX_ID + 1, "BAD_PARAMETER")):
            unit = {"component_ref": DOOR, "command_type": "list", "command_id": "x" * length}
            assert await execute(app, [unit]) == code

    async def test_characters_of_a_condition(self, app: wire.Application) -> None:
        for length, code in ((condition.MAX_LENGTH, "OK"), (condition.MAX_LENGTH + 1, "BAD_PARAMETER")):
            text = "component_ref = ''"
            answer = await app.ask("rois.command.search", condition=text[:-1] + "x" * (length - len(text)) + "'")
            assert answer["return_code"] == code

    async def test_digits_and_depth(self, app: wire.Application) -> None:
        for digits, code in ((values.MAX_DIGITS, "OK"), (values.MAX_DIGITS + 1, "BAD_PARAMETER")):
            argument = {"name": "numbers", "data_type_ref": "int[]", "value": f"[{'9' * digits}]"}
            unit = {"component_ref": DOOR, "command_type": "list", "command_id": str(digits), "arguments": [argument]}
            assert (digits, await execute(app, [unit])) == (digits, code)
        for depth in (values.MAX_DEPTH, values.MAX_DEPTH + 1):
            text = "[" * depth + "]" * depth
            if depth <= values.MAX_DEPTH:
                values.check_value("int" + "[]" * depth, text)
            else:
                with pytest.raises(ValueError, match="nested"):
                    values.check_value("int" + "[]" * depth, text)


class TestEvents:
    async def subscribe(self, app: wire.Application) -> str:
        return str((await app.ask("rois.event.subscribe", event_type="rang"))["return_code"])

    async def details(self, app: wire.Application, event_id: str) -> str:
        return str((await app.ask("rois.event.get_event_detail", event_id=event_id))["return_code"])

    async def ring(self, app: wire.Application, bell: Bell, count: int, tune: str) -> list[str]:
        """Let the bell ring and return the event ids."""
        ids = []
        for _ in range(count):
            bell.ring(tune)
            ids.append((await app.next("rois.event.notify_event"))["event_id"])
        return ids

    async def test_subscriptions(self, app: wire.Application) -> None:
        assert {await self.subscribe(app) for _ in range(events.MAX_SUBSCRIPTIONS)} == {"OK"}
        assert await self.subscribe(app) == "OUT_OF_RESOURCES"

    async def test_remembered_events(self, app: wire.Application, bell: Bell) -> None:
        await self.subscribe(app)
        ids = await self.ring(app, bell, events.MAX_DETAILS + 1, "ding")
        assert [await self.details(app, event_id) for event_id in ids[:2]] == ["BAD_PARAMETER", "OK"]

    async def test_text_of_events(self, app: wire.Application, bell: Bell) -> None:
        await self.subscribe(app)
        tune = "x" * (MIB // 2 - KIB)
        ids = await self.ring(app, bell, bounded_history.MAX_TEXT // (MIB // 2) + 1, tune)
        assert [await self.details(app, event_id) for event_id in ids[:2]] == ["BAD_PARAMETER", "OK"]


class TestConnections:
    def test_messages_that_wait(self) -> None:
        waiting = outbox.Outbox()
        for number in range(outbox.CONTROL_LIMIT):
            waiting.put(str(number))
        for number in range(outbox.EVENT_LIMIT + 1):
            waiting.put(str(number), droppable=True)
        assert waiting.dropped == 1
        with pytest.raises(outbox.OutboxOverflow):
            waiting.put("one more")

    async def test_requests_that_run(self, host: EngineHost, app: wire.Application, door: Door) -> None:
        door.may_answer.clear()
        doors = [Door(str(number)) for number in range(request_queue.MAX_RUNNING_REQUESTS // registry.MAX_QUERIES)]
        for other in doors:
            other.may_answer = door.may_answer
        await host.engine.attach(LocalRegistry("house", doors))
        asked = [
            asyncio.ensure_future(
                app.ask("rois.query.query", query_type="view", condition=f"component_ref = 'house/{other.name}'")
            )
            for other in doors
            for _ in range(registry.MAX_QUERIES)
        ]
        await doors[-1].asked.wait()
        after = asyncio.ensure_future(app.ask("rois.system.connect"))
        await settle()
        assert not after.done()
        door.may_answer.set()
        async with deployment.patience():
            assert {answer["return_code"] for answer in await asyncio.gather(*asked, after)} == {"OK"}

    async def test_problems(self, app: wire.Application) -> None:
        with pytest.raises(session.RpcError) as refused:
            await app.ask("rois.system.connect", **{str(number): 1 for number in range(handler.MAX_PROBLEMS + 1)})
        assert len(refused.value.data) == handler.MAX_PROBLEMS

    async def test_lists_of_extensions(self, app: wire.Application) -> None:
        answer = await app.ask("openrois.hello", version="1", extensions=["x"] * streams.MAX_EXTENSIONS)
        assert answer["return_code"] == "OK"
        parameter = {"name": "x", "data_type_ref": "x", "value": "x"}
        connect = {"component_ref": DOOR, "parameters": [parameter] * streams.MAX_PARAMETERS}
        assert (await app.ask("rois.stream.connect_stream", **connect))["return_code"] == "UNSUPPORTED"
        calls_beyond: list[tuple[str, dict[str, Any]]] = [
            ("openrois.hello", {"version": "1", "extensions": ["x"] * (streams.MAX_EXTENSIONS + 1)}),
            ("rois.stream.connect_stream", {**connect, "parameters": [parameter] * (streams.MAX_PARAMETERS + 1)}),
        ]
        for method, params in calls_beyond:
            with pytest.raises(session.RpcError) as refused:
                await app.ask(method, **params)
            assert refused.value.code == -32602

    async def test_the_time_for_an_answer(self, monkeypatch: pytest.MonkeyPatch) -> None:
        assert GatewaySettings().adapter_timeout == session.CALL_TIMEOUT
        sessions = deployment.adapter_sessions(monkeypatch)
        async with AsyncExitStack() as stack:
            gateway = await stack.enter_async_context(deployment.gateway())
            await stack.enter_async_context(deployment.adapter(gateway, Bell()))
            assert sessions[0].call_timeout == session.CALL_TIMEOUT
