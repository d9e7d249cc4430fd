"""The robot's error codes in words."""

import json
from typing import Any

from kachaka_api.generated import kachaka_api_pb2 as pb2

from openrois.adapter import ComponentFailed
from openrois_robots.kachaka.api.calls import KachakaApi

__all__ = ["ErrorTexts"]


class ErrorTexts:
    """Sentences of error codes; codes whose texts the robot has not told are numbers.

    Args:
        api: of the robot.
    """

    def __init__(self, api: KachakaApi) -> None:
        self._api = api
        self._texts: dict[int, str] = {}

    @property
    def is_known(self) -> bool:
        """Whether the robot has told its texts."""
        return bool(self._texts)

    async def load(self) -> None:
        """Ask the robot for all texts.

        Raises:
            RoISError: the call failed, as `KachakaApi.call` says.
        """
        response: pb2.GetRobotErrorCodeJsonResponse = await self._api.call("GetRobotErrorCodeJson", pb2.EmptyRequest())
        self._texts = _read(response.json)

    def sentence(self, code: int) -> str:
        """Return an error in words, with its code."""
        text = self._texts.get(code, "")
        return f"{text} (error {code})" if text else f"error {code}"

    def require_success(self, result: pb2.Result, doing: str) -> None:
        """Do nothing where a result is a success.

        Raises:
            ComponentFailed: it is none; the sentence says what was not done, and why.
        """
        if not result.success:
            raise ComponentFailed(f"the robot did not {doing}: {self.sentence(result.error_code)}")


def _read(text: str) -> dict[int, str]:
    """Return the texts by their codes; what cannot be read is left out."""
    try:
        items = json.loads(text)
    except (ValueError, RecursionError):
        return {}
    found = (_entry(item) for item in items if isinstance(item, dict)) if isinstance(items, list) else ()
    return {code: sentence for code, sentence in found if code is not None and sentence}


def _entry(item: dict[str, Any]) -> tuple[int | None, str]:
    code = item.get("code")
    parts = [item.get("title_en") or item.get("title"), item.get("description_en") or item.get("description")]
    words = ": ".join(str(part).strip().rstrip(".") for part in parts if part)
    return (code if type(code) is int else None), words
