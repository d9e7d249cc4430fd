"""What the sensing components have in common, on a small one."""

import asyncio
from collections.abc import Mapping

import pytest
from openrois_body.components.sensing import Localizing, Sense
from openrois_body.sensing.changes import Place

from openrois.adapter import components
from openrois.component.component import Component
from openrois.engine.registry import LocalRegistry
from openrois.errors import BadParameter
from openrois.testing import ComponentContract, memory_gateway
from openrois.types.messages import Argument


class Detection(Sense, components.FaceDetection):
    """Detects nothing by itself."""


class Localization(Localizing, components.FaceLocalization):
    """Localizes nothing by itself."""


class TestDetection(ComponentContract):
    async def component(self) -> Component:
        return Detection()


class TestLocalization(ComponentContract):
    parameters: Mapping[str, str] = {"detection_threshold": "50"}

    async def component(self) -> Component:
        return Localization()


async def test_sense_is_active_by_subscription_and_by_start() -> None:
    sense = Detection()
    registry = LocalRegistry("avatar", [sense])
    works: list[bool] = []
    sense.activity.changed.add(works.append)
    subscribe_id = await registry.subscribe("avatar/face_detecter", "face_detected", lambda _item: None)
    for command in ("suspend", "resume", "start"):
        await registry.invoke("avatar/face_detecter", command)
    await registry.unsubscribe(subscribe_id)
    await registry.invoke("avatar/face_detecter", "stop")
    assert works == [True, False, True, False]
    assert [each.name for each in sense.profile.command_profiles] == ["start", "stop", "suspend", "resume"]


async def test_an_application_that_leaves_lets_its_senses_rest() -> None:
    sense = Detection()
    works: asyncio.Queue[bool] = asyncio.Queue()
    sense.activity.changed.add(works.put_nowait)
    async with memory_gateway(sense) as gateway, asyncio.timeout(60):
        for _ in range(2):
            async with gateway.client() as client, client.component("robot/face_detecter").event("face_detected"):
                assert await works.get()
            assert not await works.get()


async def test_places_are_told_as_the_parameters_say() -> None:
    sense = Localization()
    registry = LocalRegistry("avatar", [sense])

    async def set_parameter(name: str, value: str) -> None:
        argument = Argument(name=name, data_type_ref="int", value=value)
        await registry.invoke("avatar/face_localizer", "set_parameter", (argument,))

    await set_parameter("detection_threshold", "100")
    await set_parameter("minimum_interval", "1000")
    for name in ("detection_threshold", "minimum_interval"):
        with pytest.raises(BadParameter):
            await set_parameter(name, "-1")
    places = [({"a": Place(x, 1.0, 0.0)}, now) for x, now in ((0.0, 0.0), (0.05, 2.0), (0.2, 2.5), (0.4, 3.0))]
    assert [sense.is_news(each, now) for each, now in places] == [True, False, True, False]
