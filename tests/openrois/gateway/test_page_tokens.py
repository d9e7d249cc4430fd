"""A gateway for this machine alone gives its page tokens: visitors are told apart, and rank above what shows none."""

from pathlib import Path

import jwt
import pytest
from aiohttp import ClientSession

from openrois.adapter.running import serve
from openrois.auth.principal import LOCAL, Role
from openrois.auth.ranks import Ranks
from openrois.client import Client
from openrois.errors import OutOfResources
from openrois.gateway.page_tokens import PageTokens
from openrois.gateway.server import Gateway, run_gateway
from openrois.gateway.settings import GatewaySettings
from openrois.types.leases import LeaseState
from tests.support.components import Lamp
from tests.support.fleet import everything
from tests.support.guarded import fresh
from tests.support.tokens import key_file

LEGS = "robot/navigation"


async def page_token(gateway: Gateway, shown: str = "", **headers: str) -> tuple[int, str]:
    """Return the status of the answer to a page, and the token in it."""
    given = headers | ({"Authorization": f"Bearer {shown}"} if shown else {})
    async with ClientSession() as session, session.get(f"{gateway.url}page-token", headers=given) as answer:
        token = (await answer.json())["token"] if answer.status in (200, 201) else ""
        assert not token or answer.headers["Cache-Control"] == "no-store"
        return answer.status, token


def subject(token: str) -> str:
    return str(jwt.decode(token, options={"verify_signature": False})["sub"])


async def test_each_page_is_a_visitor_of_its_own_and_stays_that(caplog: pytest.LogCaptureFixture) -> None:
    async with run_gateway(GatewaySettings(port=0, auth_local=True)) as gateway:
        (_, one), (_, other) = await page_token(gateway), await page_token(gateway)
        assert (subject(one), subject(other)) == ("visitor 1", "visitor 2")
        status, renewed = await page_token(gateway, one)
        assert (status, subject(renewed)) == (200, "visitor 1")
        assert renewed != one
        status, of_a_former_gateway = await page_token(gateway, f"{one}x")
        assert (status, subject(of_a_former_gateway)) == (201, "visitor 3")
        assert await page_token(gateway, Origin="https://example.org") == (403, "")
        async with Client(gateway.url, token=renewed) as page, Client(gateway.url) as program:
            assert page.extensions == program.extensions
        assert one not in caplog.text


async def test_a_visitor_takes_over_from_a_program_without_a_token_and_not_the_other_way_round() -> None:
    async with run_gateway(GatewaySettings(port=0, auth_local=True)) as gateway:
        await gateway.engine.attach(everything("robot").registry)
        (_, one), (_, other) = await page_token(gateway), await page_token(gateway)
        async with (
            Client(gateway.url) as program,
            Client(gateway.url, token=one) as visitor,
            Client(gateway.url, token=other) as equal,
        ):
            await program.bind(LEGS)
            lease = await visitor.control.borrow(LEGS)
            assert (lease.state, lease.holder, lease.lender) == (LeaseState.MINE, "visitor 1", LOCAL.subject)
            for client in (program, equal):
                with pytest.raises(OutOfResources, match="held by visitor 1, which is not of lower rank"):
                    await client.control.borrow(LEGS)
            await visitor.control.give_back(LEGS)
            assert (await program.control.status(LEGS)).state is LeaseState.MINE


async def test_programs_have_names_and_ranks_by_a_key_beside_and_need_no_token_all_the_same(tmp_path: Path) -> None:
    settings = GatewaySettings(port=0, auth_local=True, auth_keys=(key_file(tmp_path),))
    async with run_gateway(settings) as gateway:
        await gateway.engine.attach(everything("robot").registry)
        _, page = await page_token(gateway)
        agent = fresh(sub="helper", roles=["operator"], scope=["*"], rank="agent")
        async with (
            Client(gateway.url) as nameless,
            Client(gateway.url, token=agent) as named,
            Client(gateway.url, token=page) as visitor,
        ):
            await nameless.bind(LEGS)
            lease = await named.control.borrow(LEGS)
            assert (lease.holder, lease.lender) == ("helper", LOCAL.subject)
            lease = await visitor.control.borrow(LEGS)
            assert (lease.holder, lease.lender) == ("visitor 1", "helper")
        status, renewed = await page_token(gateway, page)
        assert (status, subject(renewed)) == (200, "visitor 1")


async def test_adapters_of_this_machine_need_no_token() -> None:
    async with (
        run_gateway(GatewaySettings(port=0, auth_local=True)) as gateway,
        serve(Lamp(), engine_id="toys", gateway=gateway.url),
        Client(gateway.url) as client,
        client.notices() as notices,
    ):
        while "toys" not in {body.engine_id for body in await client.bodies()}:
            await anext(aiter(notices))


@pytest.mark.parametrize("has_keys", [False, True])
async def test_other_gateways_give_their_page_none(tmp_path: Path, has_keys: bool) -> None:
    settings = GatewaySettings(port=0, auth_keys=(key_file(tmp_path),) if has_keys else ())
    async with run_gateway(settings) as gateway:
        for shown in ("", "a.b.c"):
            assert await page_token(gateway, shown) == (204, "")


async def test_what_a_token_of_a_page_says() -> None:
    tokens = PageTokens(Ranks(("crew", "machine")), 60, clock=lambda: 1000.5)
    said = jwt.decode(tokens.issue(LOCAL), options={"verify_signature": False})
    assert (said["rank"], said["scope"], said["exp"] - said["iat"]) == ("crew", ["*"], 60)
    assert Role.OPERATOR in said["roles"]
    assert not {Role.ADMINISTRATOR, Role.ADAPTER} & set(said["roles"])
