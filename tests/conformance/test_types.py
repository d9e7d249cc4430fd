"""A component's type is a URN in every condition, whether its identifier has the URN or authority and code apart."""

from typing import Any

import pytest

from openrois.client import Client
from openrois.client.components import Navigation
from openrois.gateway.server import Gateway
from tests.support import basics, deployment
from tests.support.plain import attached, plain_adapter, profile_result

APART = {"code": "Navigation", "authority": "OMG", "codebook_ref": "", "version": ""}
WHOLE = {"code": "urn:x-rois:def:component:OMG::Navigation", "authority": "OMG", "codebook_ref": "", "version": ""}
TOY = "plain/toy"

FOUND = (
    "component_type = 'urn:x-rois:def:component:OMG::Navigation'",
    "component_type LIKE 'urn:%OMG::%'",
    "component_type LIKE '%::Navigation' AND component_ref = 'plain/toy'",
)
NOT_FOUND = ("component_type = 'Navigation'", "component_type = 'urn:x-rois:def:component:::Navigation'")


def described(identifier: dict[str, str]) -> dict[str, Any]:
    profile = profile_result("toy")
    profile["component_profiles"][TOY]["identifier"] = identifier
    return profile


@pytest.mark.parametrize("identifier", [APART, WHOLE], ids=["apart", "whole"])
async def test_every_operation_takes_a_type_as_its_urn(gateway: Gateway, identifier: dict[str, str]) -> None:
    async with plain_adapter(gateway, described(identifier)), deployment.application(gateway) as app:
        await attached(gateway)
        for condition in FOUND:
            assert (await app.ask("rois.command.search", condition=condition))["component_ref_list"] == [TOY]
            assert (await app.ask("rois.command.bind_any", condition=condition))["component_ref"] == TOY
            assert await app.code("rois.event.subscribe", event_type="laughed", condition=condition) == "OK"
            assert await app.code("rois.query.query", query_type="mood", condition=condition) == "OK"
            profile = await app.ask("rois.system.get_profile", condition=condition)
            assert list(profile["component_profiles"]) == [TOY]
            assert profile["component_profiles"][TOY]["identifier"] == identifier
        for condition in NOT_FOUND:
            assert (await app.ask("rois.command.search", condition=condition))["component_ref_list"] == []
            assert await app.code("rois.command.bind_any", condition=condition) == "UNSUPPORTED"
            assert await app.code("rois.event.subscribe", event_type="laughed", condition=condition) == "UNSUPPORTED"
            assert await app.code("rois.query.query", query_type="mood", condition=condition) == "UNSUPPORTED"
            assert (await app.ask("rois.system.get_profile", condition=condition))["component_profiles"] == {}


@pytest.mark.parametrize("identifier", [APART, WHOLE], ids=["apart", "whole"])
async def test_the_client_finds_either(gateway: Gateway, identifier: dict[str, str]) -> None:
    async with plain_adapter(gateway, described(identifier)), Client(gateway.url.replace("http", "ws")) as client:
        await attached(gateway)
        assert (await client.find(Navigation)).component_ref == TOY


async def test_our_components_say_authority_and_code_apart(gateway: Gateway) -> None:
    async with deployment.adapter(gateway, basics.Navigation()), deployment.application(gateway) as app:
        (profile,) = (await app.ask("rois.system.get_profile"))["component_profiles"].values()
    assert profile["identifier"] == APART
