from openrois.gateway.ice import STUN_TTL, IceServers


def test_each_gets_credentials_of_its_own_that_expire() -> None:
    now = [1000.9]
    ice = IceServers(("stun:s",), ("turn:t", "turns:t"), "secret", 600, lambda: now[0])
    stun, turn = ice.servers("alice")
    assert stun == {"urls": ["stun:s"]}
    assert turn["urls"] == ["turn:t", "turns:t"]
    assert turn["username"] == "1600:alice"
    assert ice.servers("bob")[1]["username"] == "1600:bob"
    now[0] = 1300.0
    assert ice.servers("alice")[1]["username"] == "1900:alice"
    assert ice.ttl == 600
    assert "secret" not in repr(ice)


def test_without_turn_there_is_nothing_secret() -> None:
    ice = IceServers(("stun:s",), (), "", 600, lambda: 0.0)
    assert ice.servers("alice") == ({"urls": ["stun:s"]},)
    assert ice.ttl == STUN_TTL
