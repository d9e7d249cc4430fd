"""STOP does not wait for what does not answer."""

import asyncio

import pytest

from openrois import stopping
from openrois.accepted import AcceptedCommands
from openrois.authoring.marks import command
from openrois.component import Component
from openrois.engine import Engine
from openrois.registry import LocalRegistry
from openrois.stopping import STOP_TIMEOUT, stop_components


class Deaf(Component, authority="Test", function="actuation"):
    """Never says that it has stopped."""

    @command
    async def stop(self) -> None:
        await asyncio.Event().wait()


async def test_what_does_not_answer_is_not_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    assert STOP_TIMEOUT == 1.0
    monkeypatch.setattr(stopping, "STOP_TIMEOUT", 0.001)
    engine = Engine("robot")
    await engine.attach(LocalRegistry("robot", [Deaf("arm"), Deaf("leg")]))
    refs = ("robot/arm", "robot/leg", "robot/none")
    failures = await stop_components(engine, AcceptedCommands(), refs, "everything stops")
    assert failures == {**dict.fromkeys(refs[:2], "no answer within 0.001 s"), "robot/none": ""}
