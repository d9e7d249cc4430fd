import argparse

import pytest
from openrois_media.network_options import add_host_options, add_network_options, host_arguments, network_settings
from openrois_streaming.network.admission import AdmissionSettings
from openrois_streaming.network.session_limits import SessionLimits
from openrois_streaming.network.settings import NetworkSettings, PortRange


def parse(*arguments: str) -> argparse.Namespace:
    parser = argparse.ArgumentParser()
    add_network_options(parser)
    return parser.parse_args(arguments)


def test_without_options_the_defaults_hold() -> None:
    assert network_settings(parse()) == NetworkSettings()


def test_chosen_options_become_settings() -> None:
    options = ("--interface", "127.0.0.1", "--udp-ports", "50000-50010", "--public-address", "203.0.113.1")
    assert network_settings(parse(*options, "--candidates", "public")) == NetworkSettings(
        ("127.0.0.1",), PortRange(50000, 50010), "203.0.113.1", candidates="public"
    )
    assert network_settings(parse("--relay-only")).relay_only
    admission = ("--peer-packets", "1", "--peer-bytes", "2", "--total-packets", "3", "--total-bytes", "4")
    assert network_settings(parse(*admission)).admission == AdmissionSettings(1, 2, 3, 4)


@pytest.mark.parametrize(("applications", "kept"), [(1, 0), (3, 0), (4, 1), (63, 15), (64, 16), (4096, 16)])
def test_a_quarter_of_the_places_is_kept_and_no_more_than_sixteen(applications: int, kept: int) -> None:
    assert network_settings(parse("--applications", str(applications))).sessions == SessionLimits(applications, kept)


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("--udp-ports", "x"), "'x' is not a range of UDP ports, such as 50000-50100"),
        (("--candidates", "wan"), "invalid choice"),
    ],
)
def test_malformed_option_is_refused_with_its_reason(
    arguments: tuple[str, ...], told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit):
        parse(*arguments)
    assert told in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("--udp-ports", "9-10"), "from 1024"),
        (("--interface", "nowhere0"), "no interface has the name or address nowhere0; use one of: .*lo"),
        (("--relay-only", "--interface", "lo"), "--relay-only excludes"),
        (("--peer-packets", "0"), "--peer-packets must be 1 or more, not 0"),
        (
            ("--applications", "8", "--kept-for-operators", "8"),
            "--kept-for-operators must be between 0 and 7, below --applications, not 8",
        ),
    ],
)
def test_unusable_option_is_refused_with_its_reason(arguments: tuple[str, ...], told: str) -> None:
    with pytest.raises(ValueError, match=told):
        network_settings(parse(*arguments))


def test_given_options_can_be_passed_on() -> None:
    parser = argparse.ArgumentParser()
    add_host_options(parser)
    given = ["--interface", "lo", "--interface", "10.0.0.1", "--udp-ports", "5000-5010"]
    assert host_arguments(parser.parse_args(given)) == given
    assert host_arguments(parser.parse_args([])) == []
