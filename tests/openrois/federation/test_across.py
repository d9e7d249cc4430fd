"""An adapter at one gateway, an application at another: what the application asks and is told passes both."""

from tests.support.cluster import cluster, seen_by
from tests.support.deployment import Robot, adapter, application
from tests.support.nats import NatsServer
from tests.support.postgres import Server


async def test_a_command_and_its_end(shared_nats: NatsServer, postgres_server: Server) -> None:
    robot = Robot()
    async with cluster(shared_nats, postgres_server, "a", "b") as both:
        async with adapter(both.gateways["a"], *robot.parts(), extension=robot.streams):
            async with application(both.gateways["b"]) as app:
                await seen_by(app, "robot")
                assert await app.code("rois.command.bind", component_ref="robot/door") == "OK"
                unit = {"component_ref": "robot/door", "command_type": "open", "command_id": "1", "arguments": []}
                assert await app.code("rois.command.execute", command_unit_list=[unit]) == "OK"
                assert await app.completed("1") == {"1": "OK"}
                assert robot.door.opened == [""]
