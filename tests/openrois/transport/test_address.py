"""Addresses of gateways, as people give them."""

import pytest

from openrois.transport.address import adapter_url, adapter_urls, gateway_url


@pytest.mark.parametrize(
    ("given", "address"),
    [
        ("ws://127.0.0.1:8765/", "ws://127.0.0.1:8765/"),
        ("ws://127.0.0.1:8765", "ws://127.0.0.1:8765/"),
        ("http://localhost:8765/", "ws://localhost:8765/"),
        ("https://robots.example/rois?site=1#top", "wss://robots.example/rois?site=1"),
        ("wss://[::1]:8765/", "wss://[::1]:8765/"),
    ],
)
def test_what_a_gateway_prints_is_its_address(given: str, address: str) -> None:
    assert gateway_url(given) == address


@pytest.mark.parametrize(
    ("given", "address"),
    [
        ("http://127.0.0.1:8765/", "ws://127.0.0.1:8765/adapter"),
        ("ws://127.0.0.1:8765", "ws://127.0.0.1:8765/adapter"),
        ("ws://127.0.0.1:8765/adapter", "ws://127.0.0.1:8765/adapter"),
        ("wss://robots.example/site/adapter?x=1", "wss://robots.example/site/adapter?x=1"),
    ],
)
def test_adapters_have_a_path_of_their_own(given: str, address: str) -> None:
    assert adapter_url(given) == address


@pytest.mark.parametrize(
    "given", ["", "127.0.0.1:8765", "ftp://127.0.0.1/", "ws://", "localhost", "ws://127.0.0.1:99999/", "ws://[::1/"]
)
def test_what_is_no_address_is_said(given: str) -> None:
    with pytest.raises(ValueError, match=r"is no address of a gateway, such as ws://127.0.0.1:8765/$"):
        gateway_url(given)
    with pytest.raises(ValueError, match=r"is no address of a gateway, such as ws://127.0.0.1:8765/adapter$"):
        adapter_url(given)


@pytest.mark.parametrize("given", ["http://a/, ws://b:1", ["http://a/", "ws://b:1"], ("http://a/", "ws://b:1/adapter")])
def test_addresses_of_several_gateways(given: str | list[str] | tuple[str, ...]) -> None:
    assert adapter_urls(given) == ("ws://a/adapter", "ws://b:1/adapter")


@pytest.mark.parametrize(
    ("given", "problem"), [("ws://a,", "'' is no address"), ("ws://a,lamp", "'lamp' is no address"), ((), "no gateway")]
)
def test_one_wrong_address_of_several_is_named(given: str | tuple[str, ...], problem: str) -> None:
    with pytest.raises(ValueError, match=problem):
        adapter_urls(given)
