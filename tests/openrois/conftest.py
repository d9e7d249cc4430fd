"""A NATS server for all tests of a worker that do not end it."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from tests.support.nats import NatsServer


@pytest.fixture(scope="session")
def shared_nats(nats: None, tmp_path_factory: pytest.TempPathFactory) -> "Iterator[NatsServer]":
    """A server that every test leaves as it was; a cluster of gateways has a prefix of its own."""
    # Most tests here run where NATS is not installed.
    from tests.support.nats import nats_server

    with nats_server(tmp_path_factory.mktemp("nats")) as server:
        yield server
