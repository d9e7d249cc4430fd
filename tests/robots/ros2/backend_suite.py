"""What every `RosBackend` does, in a graph with a node of another process (`tests.support.ros_node`)."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import AbstractAsyncContextManager, AsyncExitStack, asynccontextmanager
from typing import Any, ClassVar

import pytest
from openrois_robots.ros2.graph.backend import GoalLost, GoalRejected, Matched, NoAnswer, RosBackend
from openrois_robots.ros2.graph.matching import Qos

from openrois.errors import ComponentFailed
from tests.support.ros_graph import Peer, free_domain, peer, until

STRING = "std_msgs/msg/String"
GO = "nav2_msgs/action/NavigateToPose"


class BackendSuite:
    """The contract of a backend; a subclass says which."""

    __test__ = False
    node: ClassVar[str] = "tests.support.ros_node"

    def backend(self, domain: int) -> AbstractAsyncContextManager[RosBackend]:
        raise NotImplementedError

    @asynccontextmanager
    async def graph(self, *arguments: str) -> AsyncIterator[tuple[RosBackend, Peer]]:
        """Run the backend and the node in a domain of their own."""
        domain = free_domain()
        async with AsyncExitStack() as stack:
            node = await stack.enter_async_context(peer(self.node, str(domain), *arguments))
            backend = await stack.enter_async_context(self.backend(domain))
            await node.said("ready")
            yield backend, node

    async def matched(self, end: Matched) -> None:
        await until(lambda: end.is_matched, f"{end.name} did not match: {end.problem}")
        assert end.problem == ""

    async def test_what_is_published_comes_back_in_the_event_loop(self) -> None:
        async with self.graph() as (backend, _):
            heard: asyncio.Queue[str] = asyncio.Queue()
            back = backend.subscribe("/back", STRING, Qos(), lambda message: heard.put_nowait(message.data))
            there = backend.publisher("/there", STRING, Qos())
            await self.matched(back)
            await self.matched(there)
            for number in range(5):
                there.publish({"data": f"said {number}"})
            async with asyncio.timeout(20):
                assert [await heard.get() for _ in range(5)] == [f"said {number}" for number in range(5)]
            there.publish({})
            async with asyncio.timeout(20):
                assert await heard.get() == ""

    async def test_a_field_that_the_type_lacks_is_refused(self) -> None:
        async with self.graph() as (backend, _):
            there = backend.publisher("/there", STRING, Qos())
            with pytest.raises(ValueError, match="text"):
                there.publish({"text": "hello"})

    async def test_a_subscriber_that_comes_late_gets_what_is_kept(self) -> None:
        async with self.graph() as (backend, _):
            heard: asyncio.Queue[str] = asyncio.Queue()
            qos = Qos("reliable", "transient_local", 1)
            backend.subscribe("/kept", STRING, qos, lambda message: heard.put_nowait(message.data))
            async with asyncio.timeout(20):
                assert await heard.get() == "from before"

    async def test_a_publisher_that_offers_less_is_said_with_what_to_change(self) -> None:
        async with self.graph("best_effort") as (backend, _):
            asking = backend.subscribe("/back", STRING, Qos("reliable"), lambda _: None)
            await until(lambda: "best_effort" in asking.problem, "nothing was said of the quality of service")
            assert not asking.is_matched
            assert asking.problem == (
                "/back is published best_effort, and the mapping file has reliable: set reliability = "
                '"best_effort" for it'
            )
            content = backend.subscribe("/back", STRING, Qos("best_effort"), lambda _: None)
            await self.matched(content)

    async def test_what_is_not_there_and_what_is_of_another_type_is_said(self) -> None:
        async with self.graph() as (backend, _):
            silent = backend.subscribe("/nothing", STRING, Qos(), lambda _: None)
            deaf = backend.publisher("/nothing_else", STRING, Qos())
            odd = backend.subscribe("/odd", STRING, Qos(), lambda _: None)
            assert silent.problem == "no node publishes /nothing"
            assert deaf.problem == "no node subscribes to /nothing_else"
            await until(lambda: "Twist" in odd.problem, "nothing was said of the type")
            assert "published as geometry_msgs/msg/Twist, and the mapping file has std_msgs/msg/String" in odd.problem
            assert not silent.is_matched
            assert not odd.is_matched

    async def test_what_was_closed_is_no_part_of_the_graph(self) -> None:
        async with self.graph() as (backend, _):
            heard: list[str] = []
            back = backend.subscribe("/back", STRING, Qos(), lambda message: heard.append(message.data))
            again: asyncio.Queue[str] = asyncio.Queue()
            other = backend.subscribe("/back", STRING, Qos(), lambda message: again.put_nowait(message.data))
            there = backend.publisher("/there", STRING, Qos())
            for end in (back, other, there):
                await self.matched(end)
            back.close()
            back.close()
            there.publish({"data": "later"})
            async with asyncio.timeout(20):
                assert await again.get() == "later"
            assert heard == []
            there.close()
            with pytest.raises(ComponentFailed):
                there.publish({"data": "more"})

    async def test_a_service_answers_in_time_or_is_said_not_to(self) -> None:
        async with self.graph() as (backend, _):
            switch = backend.service("/switch", "std_srvs/srv/SetBool")
            with pytest.raises(NoAnswer, match="the service /switch"):
                await switch.call({"data": True})
            await self.matched(switch)
            response = await switch.call({"data": True}, timeout=20)
            assert (response.success, response.message) == (True, "on")
            with pytest.raises(NoAnswer, match=r"the service /switch has not answered within 0.1 s"):
                await switch.call({"data": False}, timeout=0.1)
            both = await asyncio.gather(*(switch.call({"data": True}, timeout=20) for _ in range(10)))
            assert all(each.success for each in both)

    async def test_a_service_of_a_killed_node_does_not_keep_its_client_waiting(self) -> None:
        async with self.graph() as (backend, node):
            switch = backend.service("/switch", "std_srvs/srv/SetBool")
            await self.matched(switch)
            calling = asyncio.ensure_future(switch.call({"data": False}, timeout=60))
            await asyncio.sleep(0)
            await node.kill()
            async with asyncio.timeout(20):
                with pytest.raises(NoAnswer, match="the service /switch"):
                    await calling

    async def test_a_goal_is_accepted_gives_feedback_and_succeeds(self) -> None:
        async with self.graph() as (backend, node):
            go = backend.action("/go", GO)
            await self.matched(go)
            told: list[tuple[float, str]] = []
            goal = await go.send_goal(
                {"behavior_tree": "short", "pose": {"header": {"frame_id": "map"}}},
                lambda feedback: told.append((feedback.distance_remaining, feedback.current_pose.header.frame_id)),
                timeout=20,
            )
            async with asyncio.timeout(20):
                end = await goal.result()
            assert end.outcome == "succeeded"
            await until(lambda: len(told) == 2, "the feedback did not come")
            assert told == [(2.0, "map"), (1.0, "map")]
            await goal.cancel(timeout=20)
            await node.said("begun short")

    async def test_a_goal_can_be_rejected_or_aborted_with_its_result(self) -> None:
        async with self.graph() as (backend, _):
            go = backend.action("/go", GO)
            await self.matched(go)
            with pytest.raises(GoalRejected, match="the action /go has rejected the goal"):
                await go.send_goal({"behavior_tree": "reject"}, timeout=20)
            goal = await go.send_goal({"behavior_tree": "abort"}, timeout=20)
            async with asyncio.timeout(20):
                end = await goal.result()
            assert (end.outcome, end.result.error_code, end.result.error_msg) == ("aborted", 9, "a wall")

    async def test_a_goal_is_cancelled(self) -> None:
        async with self.graph() as (backend, node):
            go = backend.action("/go", GO)
            await self.matched(go)
            goal = await go.send_goal({"behavior_tree": "hold"}, timeout=20)
            ending = asyncio.ensure_future(goal.result())
            await node.said("begun hold")
            await goal.cancel(timeout=20)
            async with asyncio.timeout(20):
                assert (await ending).outcome == "canceled"
            await node.said("canceled")

    @pytest.mark.parametrize("how", ["timeout", "cancelled"])
    async def test_a_goal_that_is_not_waited_for_does_not_run_on(self, how: str) -> None:
        async with self.graph() as (backend, node):
            go = backend.action("/go", GO)
            await self.matched(go)
            if how == "timeout":
                with pytest.raises(NoAnswer, match="has not answered to a goal within 0 s"):
                    await go.send_goal({"behavior_tree": "hold"}, timeout=0)
            else:
                sending = asyncio.ensure_future(go.send_goal({"behavior_tree": "hold"}, timeout=20))
                await asyncio.sleep(0)
                sending.cancel()
                with pytest.raises(asyncio.CancelledError):
                    await sending
            await node.said("begun hold")
            await node.said("canceled")

    async def test_a_goal_of_a_killed_node_is_lost(self) -> None:
        async with self.graph() as (backend, node):
            go = backend.action("/go", GO)
            await self.matched(go)
            goal = await go.send_goal({"behavior_tree": "hold"}, timeout=20)
            ending: asyncio.Future[Any] = asyncio.ensure_future(goal.result())
            await node.said("begun hold")
            await node.kill()
            async with asyncio.timeout(20):
                with pytest.raises(GoalLost, match=r"the goal is lost: .*/go"):
                    await ending
            await until(lambda: not go.is_matched, "the action still has a server")
            with pytest.raises(NoAnswer):
                await goal.cancel(timeout=5)
