"""One setting, one owner: options win over the environment, that over the file, and what is unknown is named."""

from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from openrois.gateway import configuration
from openrois.gateway.configuration import PREFIX, configure, printed, settings_of
from openrois.gateway.settings import GROUPS, GatewaySettings

SECRET = "correct horse battery"


@pytest.fixture
def secret(tmp_path: Path) -> Path:
    file = tmp_path / "turn.secret"
    file.write_text(f"{SECRET}\nnot this\n")
    file.chmod(0o600)
    return file


def file_of(tmp_path: Path, text: str) -> str:
    file = tmp_path / "gateway.toml"
    file.write_text(text)
    return str(file)


def test_each_setting_has_one_owner_and_a_line_for_people() -> None:
    settings = settings_of()
    for names in zip(*((s.field, s.key, s.variable, s.option) for s in settings), strict=True):
        assert len(set(names)) == len(names)
    assert {s.field for s in settings} == set(GatewaySettings.model_fields)
    assert len({group.table for group in GROUPS}) == len(GROUPS)
    for each in settings:
        assert each.info.description
        assert not each.info.description.endswith(".")


def test_without_anything_the_defaults_hold() -> None:
    configured = configure([], {"HOME": "/", "OPENROIS_GATEWAY": "ws://elsewhere/adapter"})
    assert configured.settings == GatewaySettings()
    assert not configured.print_only


def test_options_win_over_the_environment_and_that_over_the_file(tmp_path: Path) -> None:
    file = file_of(tmp_path, '[listen]\nport = 1\nengine_id = "a"\nhost = "::1"\n[adapters]\nadapter_timeout = 2.5\n')
    environment = {f"{PREFIX}CONFIG": file, f"{PREFIX}PORT": "2", f"{PREFIX}ENGINE_ID": "b"}
    found = configure(["--port", "3", "--verbose"], environment)
    settings = found.settings
    assert (settings.port, settings.engine_id, settings.host) == (3, "b", "::1")
    assert (settings.adapter_timeout, settings.verbose) == (2.5, True)
    assert found.sources == {
        "port": "--port",
        "engine_id": f"{PREFIX}ENGINE_ID",
        "host": f"{file}: [listen] host",
        "adapter_timeout": f"{file}: [adapters] adapter_timeout",
        "verbose": "--verbose",
    }
    other = tmp_path / "other.toml"
    other.write_text("[listen]\nport = 4\n")
    assert configure(["--config", str(other)], {f"{PREFIX}CONFIG": file}).settings.port == 4
    assert not configure(["--no-verbose"], {f"{PREFIX}VERBOSE": "1"}).settings.verbose


def test_what_has_several_values(tmp_path: Path) -> None:
    servers = ("stun:a", "stun:b")
    for arguments, environment in (
        (["--ice-server", "stun:a", "--ice-server", "stun:b"], {}),
        ([], {f"{PREFIX}ICE_SERVERS": "stun:a, stun:b,"}),
        (["--config", file_of(tmp_path, '[streams]\nice_servers = ["stun:a", "stun:b"]\n')], {}),
    ):
        assert configure(arguments, environment).settings.ice_servers == servers


def test_files_that_a_file_names_are_beside_it(tmp_path: Path, secret: Path) -> None:
    text = f'[streams]\nturn = ["turn:t"]\nturn_secret_file = "{secret.name}"\n[operation]\naudit_file = "a"\n'
    found = configure(["--config", file_of(tmp_path, text)], {})
    assert (found.settings.turn_secret, found.settings.audit_file) == (SECRET, tmp_path / "a")


def test_secrets_are_shown_nowhere(tmp_path: Path, secret: Path) -> None:
    found = configure(["--turn", "turn:t", "--turn-secret-file", str(secret), "--print-config"], {})
    assert found.settings.turn_secret == SECRET
    assert SECRET in found.settings.secrets()
    assert found.print_only
    for shown in (printed(found), repr(found), str(found.settings)):
        assert SECRET not in shown
    with pytest.raises(ValueError, match="given together") as refused:
        configure(["--turn-secret-file", str(secret)], {})
    assert SECRET not in str(refused.value)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[listen]\nprot = 1", r"\[listen\] prot is no setting; is it port\?"),
        ("[listn]\nport = 1", r"\[listn\] is no table of settings; is it listen\?"),
        ("port = 1", r"\[port\] is no table"),
        ("[listen]\nturn = []", r"it belongs to \[streams\]"),
        ("[listen]\nxyzzy = 1", r"xyzzy is no setting$"),
        ('[streams]\nturn_secret = "x"', "turn_secret_file names"),
        ("[streams]\nturn_secret_file = 1", "is a text"),
        ("[listen]\nport = true\nport", "is no TOML"),
        ("[listen]\nport = []", r"gateway.toml: \[listen\] port: "),
        ("[listen]\nport = 70000", "--port must be between 0 and 65535, not 70000"),
        ("[listen]\nmost_adapters = 1000001", "--most-adapters must be between 1 and 1e"),
        ("[listen]\nmost_applications = 0", "--most-applications must be between 1 and"),
        ("[adapters]\nadapter_timeout = nan", r"\[adapters\] adapter_timeout: "),
    ],
)
def test_what_is_wrong_in_a_file_is_named(text: str, words: str, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=words) as refused:
        configure(["--config", file_of(tmp_path, text)], {})
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("environment", "words"),
    [
        ({"PROT": "1"}, rf"{PREFIX}PROT is no setting; is it {PREFIX}PORT\?"),
        ({"TURN_SECRET": "x"}, f"is it {PREFIX}TURN_SECRET_FILE"),
        ({"PORT": "x"}, f"{PREFIX}PORT: .*integer"),
        ({"CONFIG": "/nowhere/at/all.toml"}, "all.toml cannot be read: No such file"),
        ({"CONFIG": "/dev/zero"}, "too long"),
    ],
)
def test_what_is_wrong_in_the_environment_is_named(environment: dict[str, str], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        configure([], {PREFIX + name: value for name, value in environment.items()})


def test_an_option_is_never_guessed(capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        configure(["--turn-secret", "oops"], {})
    assert "is not known here" in capfd.readouterr().err


@given(
    st.fixed_dictionaries(
        {},
        optional={
            "port": st.integers(0, 65535),
            "engine_id": st.from_regex(r"[a-z]{1,8}", fullmatch=True),
            "ice_servers": st.lists(st.from_regex(r"stun:[!-~]{1,20}", fullmatch=True)).map(tuple),
            "adapter_timeout": st.floats(0.001, 3599),
            "verbose": st.booleans(),
            "audit_file": st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0"), min_size=1).map(
                lambda name: Path("/folder", name.lstrip("/"))
            ),
        },
    )
)
def test_what_is_printed_can_be_read_again(values: dict[str, Any]) -> None:
    settings = GatewaySettings(**values)
    text = printed(configuration.Configured(settings, {}, {}, (), True, False))
    read = dict(configuration._from_text(text, Path("/folder/gateway.toml")))
    assert GatewaySettings(**{name: value for name, (value, _) in read.items()}) == settings
