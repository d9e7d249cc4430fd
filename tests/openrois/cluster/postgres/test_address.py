"""The URL of a store: what it may say, and what is made of it."""

import pytest

from openrois.cluster.postgres.address import parse_store_url

pytestmark = pytest.mark.extra(name="base")

AUTHORITIES = "/etc/authorities.pem"


@pytest.mark.parametrize(
    "url",
    [
        "postgresql://openrois@localhost/store",
        "postgres://openrois@127.0.0.1:6543/store",
        "postgresql://openrois@[::1]:6543/store",
        "postgresql://openrois@/store?host=/run/postgresql",
        "postgresql:///store",
    ],
)
def test_a_server_on_this_machine_is_reached_as_it_likes(url: str) -> None:
    assert "sslmode" not in parse_store_url(url, AUTHORITIES).url


@pytest.mark.parametrize("host", ["db.example.org", "192.0.2.7:5433", "[2001:db8::7]:5433", "localhost,db.example.org"])
def test_a_server_elsewhere_is_reached_by_tls_and_verified(host: str) -> None:
    found = parse_store_url(f"postgresql://openrois@{host}/store", AUTHORITIES).url
    assert found.startswith(
        f"postgresql://openrois@{host}/store?sslmode=verify-full&sslrootcert=%2Fetc%2Fauthorities.pem"
    )


def test_what_the_url_says_of_tls_holds() -> None:
    own = "postgresql://openrois@db.example.org/store?sslmode=verify-ca&sslrootcert=%2Fown.pem"
    assert parse_store_url(own, AUTHORITIES).url == own
    plain = "postgresql://openrois@db.example.org/store?sslmode=disable"
    assert parse_store_url(plain, AUTHORITIES).url == plain


def test_a_system_without_authorities_leaves_them_to_the_library() -> None:
    url = parse_store_url("postgresql://openrois@db.example.org/store").url
    assert url == "postgresql://openrois@db.example.org/store?sslmode=verify-full"


def test_of_several_servers_the_one_is_used_that_accepts_changes() -> None:
    found = parse_store_url("postgresql://openrois@one.example.org,two.example.org:6543/store?sslmode=require")
    assert found.url.endswith("/store?sslmode=require&target_session_attrs=read-write")
    assert found.name == "PostgreSQL one.example.org,two.example.org:6543/store"


@pytest.mark.parametrize(
    ("url", "name"),
    [
        ("postgresql://openrois@db.example.org/store", "PostgreSQL db.example.org/store"),
        ("postgresql://openrois@/store?host=%2Frun%2Fpostgresql", "PostgreSQL /run/postgresql/store"),
        ("postgresql://openrois@localhost?dbname=store", "PostgreSQL localhost/store"),
        ("postgresql:///a%20store", "PostgreSQL localhost/a store"),
    ],
)
def test_a_name_has_hosts_and_database_and_no_user(url: str, name: str) -> None:
    assert parse_store_url(url).name == name


@pytest.mark.parametrize(
    ("url", "problem"),
    [
        ("nats://db.example.org", "begins with postgresql://"),
        ("postgresql://openrois:hidden@db.example.org/store", "has no password in it: write the password into a file"),
        ("postgresql://openrois@db.example.org/store?password=hidden", "has no password in it"),
        ("postgresql://openrois@db.example.org/store?sslpassword=hidden", "has no password in it"),
        ("postgresql://openrois@db.example.org", "names a database: postgresql://user@host/database"),
        ("postgresql://openrois@db.example.org/", "names a database"),
        ("postgresql://openrois@db.example.org/store?hidden", "options as name=value"),
    ],
)
def test_a_url_that_is_none_is_refused_without_its_secrets(url: str, problem: str) -> None:
    with pytest.raises(ValueError, match=problem) as refused:
        parse_store_url(url)
    assert "hidden" not in str(refused.value)
    assert refused.value.__cause__ is None
