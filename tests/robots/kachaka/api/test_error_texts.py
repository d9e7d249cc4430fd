"""Error codes in words."""

import pytest
from kachaka_api.generated import kachaka_api_pb2 as pb2
from openrois_robots.kachaka.api.calls import KachakaApi
from openrois_robots.kachaka.api.error_texts import ErrorTexts, _read

from openrois.adapter import ComponentFailed
from tests.support.kachaka import simulated


async def test_the_robots_own_texts_are_used() -> None:
    async with simulated() as (_, address), KachakaApi(address) as api:
        texts = ErrorTexts(api)
        assert not texts.is_known
        assert texts.sentence(10003) == "error 10003"
        await texts.load()
        assert texts.is_known
        assert texts.sentence(10003) == "No way: There is no way to the destination (error 10003)"
        with pytest.raises(ComponentFailed, match=r"the robot did not go: No way: There is .* \(error 10003\)"):
            texts.require_success(pb2.Result(success=False, error_code=10003), "go")
        texts.require_success(pb2.Result(success=True), "go")


@pytest.mark.parametrize(
    "text",
    [
        "",
        "no JSON",
        "[" * 100_000,
        '[{"code": 1e400, "title": "x"}]',
        '[{"code": true, "title": "x"}]',
        "{}",
        "[1, null]",
        '[{"code": "7", "title": "x"}]',
        '[{"code": 7}]',
        '[{"title": "x"}]',
    ],
)
def test_texts_that_cannot_be_read_are_left_out(text: str) -> None:
    assert _read(text) == {}


def test_a_title_in_one_language_is_enough() -> None:
    assert _read('[{"code": 7, "title": "道がありません", "description": ""}]') == {7: "道がありません"}
