"""Who still gets in when many are in already."""

from collections import Counter

import pytest
from aiohttp import web

from openrois.gateway import places as module
from openrois.gateway.places import Places


@pytest.fixture
def turned_away() -> Counter[str]:
    return Counter()


@pytest.fixture
def places(monkeypatch: pytest.MonkeyPatch, turned_away: Counter[str]) -> Places:
    monkeypatch.setattr(module, "MAX_APPLICATIONS", 3)
    monkeypatch.setattr(module, "MAX_ADAPTERS", 1)
    return Places(lambda reason: turned_away.update((reason,)), per_address=2)


def test_adapters_have_places_of_their_own(places: Places, turned_away: Counter[str]) -> None:
    with places.of_application("a"), places.of_application("a"), places.of_application("b"):
        assert places.is_full
        with pytest.raises(web.HTTPServiceUnavailable), places.of_application("c"):
            pass
        with places.of_adapter(), pytest.raises(web.HTTPServiceUnavailable), places.of_adapter():
            pass
    assert not places.is_full
    with places.of_adapter():
        assert places.is_full
        with places.of_application("c"):
            pass
    assert turned_away == {"full": 2}


def test_one_address_has_so_many(places: Places, turned_away: Counter[str]) -> None:
    with places.of_application("a"), places.of_application("a"):
        with pytest.raises(web.HTTPTooManyRequests), places.of_application("a"):
            pass
        with places.of_application("b"):
            pass
    with places.of_application("a"):
        pass
    assert turned_away == {"too many from one address": 1}
