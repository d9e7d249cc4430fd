"""What an application in C# does with an avatar's speech and visitors, without a WebRTC library."""

from pathlib import Path

import pytest

from tests.sdk_csharp.conftest import Start
from tests.support.operated import operated_avatar

pytestmark = [pytest.mark.media, pytest.mark.timeout(120)]


async def test_it_speaks_word_by_word_and_visits_with_consent_that_it_withdraws(start: Start, tmp_path: Path) -> None:
    async with operated_avatar(tmp_path) as (gateway, _), start("visiting", gateway.url) as app:
        assert await app.says("words") == ["Hello", "world"]
        assert await app.says("end") == ["OK", True]
        assert await app.says("speeches") == 0
        assert await app.says("comes") == ["microphone", "live"]
        assert await app.says("is named") is True
        assert await app.says("consents") == ["microphone", "agent live"]
        assert await app.says("present") is True
        assert await app.says("withdraws") == ["microphone", ""]
        assert (await app.says("leaves"))[0] == ""
        assert await app.says("is unknown") == "UnsupportedException"
        await app.ends()
