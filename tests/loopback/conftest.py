from collections.abc import Iterator

import pytest

from tests.support.demo import Demo, running_demo


@pytest.fixture(scope="session")
def demo(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Demo]:
    """A demo that all loopback tests share. What went wrong in it unseen is in its log."""
    with running_demo(tmp_path_factory.mktemp("demo")) as running:
        yield running
        assert "Traceback" not in running.log(), running.log()
