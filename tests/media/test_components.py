"""The streaming components as any application sees them: parameters that are set, and parameters that are only read."""

import json

import pytest
from openrois_media.components import AudioStreaming, VideoStreaming

from openrois.engine.registry import LocalRegistry
from openrois.errors import BadParameter
from openrois.types.codes import ComponentStatus
from openrois.types.messages import Argument

VIDEO = "avatar/video_streaming"


@pytest.fixture
def registry() -> LocalRegistry:
    return LocalRegistry(
        "avatar", [VideoStreaming(("video/VP8",), ("recvonly", "sendonly"), lambda: ComponentStatus.READY)]
    )


async def set_parameters(registry: LocalRegistry, **values: str) -> None:
    arguments = tuple(Argument(name=name, data_type_ref="String", value=value) for name, value in values.items())
    await registry.invoke(VIDEO, "set_parameter", arguments)


async def parameters(registry: LocalRegistry) -> dict[str, str]:
    return {parameter.name: parameter.value for parameter in await registry.query(VIDEO, "get_parameter")}


async def test_what_is_wanted_is_set(registry: LocalRegistry) -> None:
    wanted = json.dumps({"codecs": ["video/VP8"]})
    await set_parameters(registry, encoding_parameters=wanted)
    assert (await parameters(registry))["encoding_parameters"] == wanted


@pytest.mark.parametrize("name", ["available_encodings", "available_transports"])
async def test_available_encodings_are_read_only(registry: LocalRegistry, name: str) -> None:
    before = await parameters(registry)
    with pytest.raises(BadParameter, match=f"{name} is read-only"):
        await set_parameters(registry, encoding_parameters="{}", **{name: ""})
    assert await parameters(registry) == before


@pytest.mark.parametrize("status", [ComponentStatus.READY, ComponentStatus.WARNING, ComponentStatus.ERROR])
@pytest.mark.parametrize("kind", [VideoStreaming, AudioStreaming])
def test_status_follows_the_source(kind: type[VideoStreaming | AudioStreaming], status: ComponentStatus) -> None:
    assert kind(("a/b",), ("recvonly",), lambda: status).status is status


async def test_available_encodings_are_published(registry: LocalRegistry) -> None:
    told = await parameters(registry)
    assert json.loads(told["available_encodings"]) == {"codecs": ["video/VP8"]}
    assert json.loads(told["available_transports"]) == {"direction": ["recvonly", "sendonly"]}
