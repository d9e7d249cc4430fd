"""Resume tokens."""

from openrois.leases.tokens import Redeemed, ResumeTokens, new_token


def test_tokens_are_long_and_differ() -> None:
    tokens = {new_token() for _ in range(100)}
    assert len(tokens) == 100
    assert min(map(len, tokens)) * 6 >= 256


def test_one_is_good_once_and_for_one_subject() -> None:
    tokens = ResumeTokens()
    token = tokens.issue("session", "ann")
    assert tokens.find(token, "bob") == Redeemed()
    assert tokens.find("guess", "ann") == Redeemed()
    assert tokens.find("\ud800", "ann") == Redeemed()
    assert tokens.find(token, "ann") == Redeemed("session")
    tokens.succeed("session", "next")
    assert tokens.find(token, "ann") == Redeemed("next", replayed=True)


def test_the_next_replaces_the_one_before() -> None:
    tokens = ResumeTokens()
    first, second = tokens.issue("session", "ann"), tokens.issue("session", "ann")
    assert tokens.find(second, "ann") == Redeemed("session")
    assert tokens.find(first, "ann").replayed
    assert not tokens.has_one("session")
    assert tokens.find(second, "ann").replayed


def test_a_forgotten_token_is_unknown() -> None:
    tokens = ResumeTokens()
    token = tokens.issue("session", "ann")
    tokens.forget_holder("session")
    tokens.forget_holder("session")
    assert tokens.find(token, "ann") == Redeemed()
    assert not tokens.has_one("session")


def test_not_all_of_them_are_remembered() -> None:
    tokens = ResumeTokens()
    issued = [tokens.issue("session", "ann") for _ in range(70)]
    known = [token for token in issued if tokens.find(token, "ann") != Redeemed()]
    assert len(known) == 65
    assert known == issued[-65:]
