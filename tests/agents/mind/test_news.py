"""What waits for a conversation: what is dropped where there is too much."""

import asyncio

import pytest
from openrois_agents.mind.news import CutShort, News, Over
from openrois_agents.mind.words import Words
from openrois_agents.tools.event_log import LoggedEvent


def words(number: int, final: bool = True) -> Words:
    return Words(f"word {number}", final, "", "avatar")


async def taken(news: News, count: int) -> list[object]:
    return [await asyncio.wait_for(news.take_next(), 5) for _ in range(count)]


async def test_a_flood_of_sentences_pushes_out_no_event_and_no_end() -> None:
    news = News()
    lost = LoggedEvent(1, "", "body_lost", "avatar", {})
    news.add_event(lost)
    news.post(CutShort(1))
    for number in range(200):
        news.add_words(words(number))
    assert await taken(news, 64) == [lost, CutShort(1), *(words(number) for number in range(138, 200))]


async def test_words_that_are_being_said_push_nothing_out() -> None:
    news = News()
    for number in range(64):
        news.add_words(words(number))
    news.add_words(words(64, final=False))
    assert await taken(news, 64) == [words(number) for number in range(64)]


async def test_without_words_the_oldest_makes_room() -> None:
    news = News()
    for number in range(65):
        news.post(Over(number))
    assert await taken(news, 64) == [Over(number) for number in range(1, 65)]


async def test_events_that_a_conversation_does_not_heed_are_left_out() -> None:
    news = News()
    news.add_event(LoggedEvent(1, "", "body_reserved", "avatar", {}))
    news.post(Over(1))
    assert await taken(news, 1) == [Over(1)]
    with pytest.raises(TimeoutError):
        await asyncio.wait_for(news.take_next(), 0.01)
