"""What an application does with streams, step by step."""

from tests.support.deployment import Application

CAMERA = "robot/camera"
STATUS = "rois.stream.notify_stream_status"


async def stream_of(app: Application, ref: str = CAMERA) -> str:
    answer = await app.ask("rois.stream.connect_stream", component_ref=ref)
    assert answer["return_code"] == "OK"
    return str(answer["stream_id"])


async def peer_of(app: Application) -> str:
    return str((await app.next("signaling.offer"))["peer_id"])


async def statuses(app: Application, count: int) -> list[str]:
    return [(await app.next(STATUS))["status"].removeprefix("STREAMING_") for _ in range(count)]


async def execute(app: Application, command_id: str, verb: str, stream_id: str | None = None) -> str:
    """Run a verb in strict RoIS and return how it ended."""
    value = {"name": "stream_id", "data_type_ref": "String", "value": stream_id or ""}
    arguments = [value] if stream_id is not None else []
    unit = {"component_ref": CAMERA, "command_type": verb, "command_id": command_id, "arguments": arguments}
    assert await app.code("rois.command.execute", command_unit_list=[unit]) == "OK"
    return (await app.completed(command_id))[command_id]
