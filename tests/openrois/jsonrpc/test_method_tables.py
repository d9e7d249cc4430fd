"""Methods of connections that share their tables: each is called for its owner."""

import pytest

from openrois.jsonrpc.handler import Reply
from openrois.jsonrpc.method_tables import BoundMethods


async def _greet(owner: str, params: dict[str, str]) -> Reply:
    return Reply(f"{owner} greets {params['name']}")


async def _leave(owner: str, _params: dict[str, str]) -> Reply:
    return Reply(f"{owner} leaves")


GREETING = {"greet": _greet}
BOTH = {"greet": _greet, "leave": _leave}


async def test_a_method_is_called_for_its_owner() -> None:
    ann, ben = BoundMethods((GREETING, "Ann")), BoundMethods((GREETING, "Ben"))
    assert [await each["greet"]({"name": "Cid"}) for each in (ann, ben)] == [
        Reply("Ann greets Cid"),
        Reply("Ben greets Cid"),
    ]


async def test_of_one_name_the_first_counts() -> None:
    methods = BoundMethods((GREETING, "Ann")).before(BoundMethods((BOTH, "Ben")))
    assert await methods["greet"]({"name": "Cid"}) == Reply("Ann greets Cid")
    assert await methods["leave"]({}) == Reply("Ben leaves")
    assert (list(methods), len(methods)) == (["greet", "leave"], 2)


def test_what_is_not_there_is_missing() -> None:
    methods = BoundMethods((GREETING, "Ann"))
    assert [name in methods for name in ("greet", "leave")] == [True, False]
    assert methods.get("leave") is None
    with pytest.raises(KeyError):
        methods["leave"]
