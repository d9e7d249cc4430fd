"""A new token in time: shown when the gateway says that the present one ends, and again until it is a newer one."""

import asyncio
from typing import Any

import pytest

from openrois.aio.tasks import TaskScope
from openrois.jsonrpc.session import SessionClosed
from openrois.jsonrpc.token_renewal import ATTEMPTS, renew_token
from openrois.transport.credentials import Credentials


class Gateway:
    """Answers each token that it is shown."""

    def __init__(self, *answers: Any) -> None:
        self.answers = list(answers)
        self.shown: list[str] = []

    async def call(self, name: str, params: dict[str, Any]) -> Any:
        assert name == "openrois.auth.refresh"
        self.shown.append(params["token"])
        answer = self.answers.pop(0)
        if isinstance(answer, Exception):
            raise answer
        return answer


async def settled() -> None:
    """Let everything run that waits for nothing else."""
    for _ in range(100):
        await asyncio.sleep(0)


GOOD = {"return_code": "OK", "seconds": 900}
SHORT = {"return_code": "OK", "seconds": 40}


@pytest.mark.parametrize(
    ("answers", "shown"),
    [
        ([GOOD], 1),
        ([SHORT, GOOD], 2),
        ([{"return_code": "BAD_PARAMETER", "seconds": 0}, "nonsense", GOOD], 3),
        ([TimeoutError(), GOOD], 2),
        ([SessionClosed("over")], 1),
        ([SHORT] * ATTEMPTS, ATTEMPTS),
    ],
    ids=["new", "not yet", "refused", "late", "over", "never"],
)
async def test_until_it_is_a_new_one(answers: list[Any], shown: int) -> None:
    gateway, tokens = Gateway(*answers), iter(f"t{number}" for number in range(10))
    slept: list[float] = []

    async def sleep(seconds: float) -> None:
        slept.append(seconds)

    async with TaskScope() as tasks:
        session: Any = gateway
        (expiring,) = renew_token(session, Credentials(lambda: next(tokens)), tasks, sleep).values()
        expiring({"seconds": 60})
        await settled()
    assert gateway.shown == [f"t{number}" for number in range(shown)]
    assert slept == [10.0] * (shown - 1)


async def test_a_file_that_is_gone_is_looked_for_again() -> None:
    found = iter([ValueError("no file"), "token"])

    def token() -> str:
        here = next(found)
        if isinstance(here, Exception):
            raise here
        return str(here)

    async def sleep(_seconds: float) -> None:
        return None

    gateway: Any = Gateway(GOOD)
    async with TaskScope() as tasks:
        (expiring,) = renew_token(gateway, Credentials(token), tasks, sleep).values()
        expiring({})
        await settled()
    assert gateway.shown == ["token"]


async def test_one_token_and_no_other() -> None:
    class Nothing:
        pass

    session: Any = Nothing()
    async with TaskScope() as tasks:
        assert renew_token(session, Credentials("only"), tasks) == {}
        assert renew_token(session, Credentials(), tasks) == {}
