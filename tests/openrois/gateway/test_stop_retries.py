"""STOP and a program that does not give up: real connections, and attempts as fast as they are answered."""

import asyncio
import time
from collections.abc import Callable
from pathlib import Path

from openrois import adapter
from openrois.aio.tasks import TaskScope
from openrois.client import Client, OutOfResources
from openrois.errors import Aborted
from openrois.gateway.server import run_gateway
from openrois.gateway.settings import GatewaySettings
from tests.support.components import Lamp
from tests.support.loopback import PATIENCE
from tests.support.tokens import issue, key_file

LAMP = "robot/lamp"


def token(subject: str, role: str = "operator", **more: str) -> str:
    return issue(time.time(), sub=subject, roles=[role], scope=["robot/*"], **more)


class Retrying:
    """A program that commands the lamp again as soon as it is answered, whatever the answer is."""

    def __init__(self, client: Client) -> None:
        self.done = self.refused = 0
        self.reasons: set[str] = set()
        self._client = client

    async def run(self) -> None:
        while True:
            try:
                await self._client.component(LAMP).command("switch")
            except (OutOfResources, Aborted) as error:
                self.refused += 1
                self.reasons.add(str(error))
            else:
                self.done += 1


async def until(so: Callable[[], object]) -> None:
    """Wait for what is not announced."""
    async with asyncio.timeout(PATIENCE):
        while not so():  # noqa: ASYNC110 - see above
            await asyncio.sleep(0.01)


async def test_a_program_that_retries_all_the_time_moves_nothing_until_a_person_hands_back(tmp_path: Path) -> None:
    (tmp_path / "adapter.token").write_text(token("robot", "adapter"))
    lamp, settings = Lamp(), GatewaySettings(port=0, auth_keys=(key_file(tmp_path),))
    async with (
        run_gateway(settings) as gateway,
        adapter.serve(lamp, engine_id="robot", gateway=gateway.url, token_file=tmp_path / "adapter.token"),
    ):
        await until(lambda: gateway.engine.components)
        url = gateway.url.replace("http", "ws", 1)
        async with (
            Client(url, token=token("agent", rank="agent")) as agent,
            Client(url, token=token("ann", rank="person")) as ann,
            TaskScope() as tasks,
        ):
            await agent.bind(LAMP)
            program = Retrying(agent)
            tasks.start(program.run())
            await until(lambda: program.done >= 20)
            await ann.call("openrois.stop_all", engine_id="robot")
            stopped_at, refused = lamp.total, program.refused
            await until(lambda: program.refused >= refused + 200)
            assert lamp.total == stopped_at
            assert any("stopped by ann: programs wait until a person hands it back" in each for each in program.reasons)
            # The person goes on meanwhile.
            await ann.control.borrow(LAMP)
            await ann.component(LAMP).command("switch")
            assert lamp.total == stopped_at + 1
            await ann.control.give_back(LAMP)
            refused = program.refused
            await until(lambda: program.refused >= refused + 100)
            assert lamp.total == stopped_at + 1
            await ann.call("openrois.lease.release_stop", engine_id="robot")
            # The loan did not come back to it while the body was stopped.
            await agent.bind(LAMP)
            done = program.done
            await until(lambda: program.done > done)
