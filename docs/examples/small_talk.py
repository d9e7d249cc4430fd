"""Small talk by an OpenAI-compatible server, for visitors that consent to it; `guide.py` uses it."""

import json
from urllib.parse import urlsplit

from aiohttp import ClientError, ClientSession, ClientTimeout

from openrois.client import Client
from openrois.types.codes import Purpose

VISITORS = "urn:x-rois:def:component:OpenRoIS::Visitors"
TASK = "You are a guide in a house. Answer in one short, friendly sentence."
TIMEOUT = 10.0
"""Seconds for an answer."""
LONGEST = 64_000
"""Bytes of an answer that are read."""
SPOKEN = 300
"""Characters of it that are spoken."""


class NoAnswer(Exception):
    """The server is down, or says nothing that can be spoken."""


class SmallTalk:
    """Asks one server, which gets a visitor's words and nothing else, and has no tools: it can make the guide talk.

    Args:
        client: of the guide.
        url: the server's address, such as `http://127.0.0.1:8080/v1`; empty for none.
    """

    def __init__(self, client: Client, url: str) -> None:
        self._client = client
        self._url = url

    async def answer(self, words: str, visitor: str) -> str:
        """Return one sentence; an empty one where there is no server, or the visitor does not consent.

        Raises:
            NoAnswer: what the server lacks.
        """
        if not self._url or not await self._consents(visitor):
            return ""
        messages = [{"role": "system", "content": TASK}, {"role": "user", "content": words}]
        try:
            told = await self._post({"model": "default", "messages": messages})
            text = json.loads(told)["choices"][0]["message"]["content"]
        except (ClientError, TimeoutError, ValueError, LookupError, TypeError) as error:
            raise NoAnswer(f"{self._url}: {error!r}") from error
        if not isinstance(text, str) or not text.strip():
            raise NoAnswer(f"{self._url}: it said nothing")
        return text[:SPOKEN]

    async def _post(self, question: object) -> bytes:
        async with (
            ClientSession(timeout=ClientTimeout(TIMEOUT), raise_for_status=True) as http,
            http.post(f"{self._url}/chat/completions", json=question) as answer,
        ):
            told = bytearray()
            async for part in answer.content.iter_any():
                told += part
                if len(told) > LONGEST:
                    raise ValueError(f"its answer has more than {LONGEST} bytes")
            return bytes(told)

    async def _consents(self, visitor: str) -> bool:
        """Tell whether a visitor's words may go to the server. Of a body that tells no visitors apart none may.

        Nor where a body lists them in a form that is not understood.
        """
        needed = {Purpose.AGENT}
        if urlsplit(self._url).hostname not in ("127.0.0.1", "::1", "localhost"):
            needed.add(Purpose.TRANSFER)
        given: dict[str, str] = {}
        for info in await self._client.bodies():
            for ref in info.refs(VISITORS):
                there = await self._client.component(ref).query("visitors")
                try:
                    given |= zip(there["visitor_ref"], there["consent"], strict=True)
                except (LookupError, ValueError, TypeError):
                    return False
        return needed <= set(given.get(visitor, "").split())
