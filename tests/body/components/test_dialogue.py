"""Dialogue: it holds for the application that holds the voice, and for that one alone."""

import json

import pytest
from openrois_body.components.dialogue import Dialogue

from openrois.adapter.running import hosted
from openrois.contract import Client, Event
from openrois.errors import BadParameter
from openrois.session.session import EngineHost
from openrois.types.messages import Argument
from openrois.types.streams import HolderNotification

REF = "avatar/dialogue"
DEFAULTS = {"sent_to": "", "can_be_said": "[]", "wake_word": ""}
SET = {"sent_to": "https://model.example", "can_be_said": '["wave", "go to the plant"]', "wake_word": "computer"}


def client(client_id: str) -> Client:
    return Client(client_id, lambda _method, _params: None)


async def write(host: EngineHost, **values: str) -> None:
    arguments = (Argument(name=name, data_type_ref="string", value=value) for name, value in values.items())
    await host.engine.invoke(REF, "set_parameter", tuple(arguments))


async def read(host: EngineHost) -> dict[str, str]:
    values = await host.engine.query(REF, "get_parameter")
    return DEFAULTS | {each.name: each.value for each in values}


async def holds(host: EngineHost, by: Client, epoch: int, *, has: bool = True) -> None:
    notice = HolderNotification(component_ref=REF, holds=has, epoch=epoch)
    await host.engine.extension.set_holder(notice, by)


@pytest.mark.parametrize("way", ["released", "lent", "gone"])
async def test_it_has_its_defaults_again_without_its_holder(way: str) -> None:
    mind, person = client("mind"), client("person")
    async with hosted("avatar", Dialogue()) as host:
        told: list[dict[str, str]] = []

        def take(event: Event | object) -> None:
            assert isinstance(event, Event)
            told.append({each.name: each.value for each in event.results})

        await host.engine.subscribe(REF, "changed", take)
        await holds(host, mind, 1)
        await write(host, **SET)
        assert await read(host) == SET
        if way == "released":
            await holds(host, mind, 1, has=False)
        elif way == "lent":
            await holds(host, person, 2)
        else:
            await host.engine.extension.forget_client(mind)
        assert await read(host) == DEFAULTS
        assert told == [SET, DEFAULTS]


async def test_it_stays_while_its_holder_binds_anew_and_another_application_leaves() -> None:
    mind, person = client("mind"), client("person")
    async with hosted("avatar", Dialogue()) as host:
        await holds(host, mind, 1)
        await write(host, **SET)
        await holds(host, mind, 2)
        await holds(host, person, 1, has=False)
        await host.engine.extension.forget_client(person)
        assert await read(host) == SET


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("sent_to", "model.example"),
        ("sent_to", "https://model.example/path?key=secret"),
        ("sent_to", "https://user:secret@model.example"),
        ("sent_to", f"https://{'m' * 249}"),
        ("can_be_said", json.dumps(["wave"] * 21)),
        ("can_be_said", json.dumps(["w" * 81])),
        ("can_be_said", '[""]'),
        ("wake_word", "w" * 41),
    ],
)
async def test_what_is_too_long_or_names_more_than_a_host_is_refused(name: str, value: str) -> None:
    async with hosted("avatar", Dialogue()) as host:
        with pytest.raises(BadParameter, match=name):
            await write(host, **{name: value})
        assert await read(host) == DEFAULTS
