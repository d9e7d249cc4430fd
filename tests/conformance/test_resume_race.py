"""A resume token that fifty show at once: it is good for one, known or not that its connection is lost."""

import asyncio
import json
from contextlib import AsyncExitStack

from openrois.gateway.server import Gateway
from tests.support import deployment
from tests.support.deployment import Adapter, Application

LAMP = "robot/lamp"
THIEVES = 50


async def test_a_stolen_token_is_good_for_one(gateway: Gateway, adapter: Adapter, stack: AsyncExitStack) -> None:
    holder = await stack.enter_async_context(deployment.application(gateway))
    await holder.ask("openrois.hello", version="1")
    assert await holder.code("rois.command.bind", component_ref=LAMP) == "OK"
    token = (await holder.ask("openrois.lease.token"))["token"]
    racing = [await stack.enter_async_context(deployment.application(gateway)) for _ in range(THIEVES)]
    for one in racing:
        await one.ask("openrois.hello", version="1")
    holder.socket.transport.abort()
    await holder.socket.wait_closed()

    async def resume(one: Application) -> str:
        return await one.code("openrois.lease.resume", token=token)

    codes = await asyncio.gather(*(resume(one) for one in racing))
    winners = [one for one, code in zip(racing, codes, strict=True) if code == "OK"]
    assert len(winners) == 1
    holders = [one for one in racing if await one.code("rois.command.bind", component_ref=LAMP) == "OK"]
    assert holders == winners
    assert token not in json.dumps([each for one in racing for each in one.heard])
