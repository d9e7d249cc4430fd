"""The command `openrois mcp`: its options, what it says of mistakes, how little it loads before it greets a host."""

import json
import re
import socket
import subprocess
import sys
from typing import Any

import pytest
from openrois_agents.mcp import command

from openrois.extras import MissingExtra
from tests.support.packages import ROOT

pytestmark = pytest.mark.extra(name="mcp")


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--gateway", "nonsense"], "--gateway: 'nonsense' is no address of a gateway"),
        (["--tools", "say,fly"], "there is no 'fly': there are say, gesture, look_at, go_to, call"),
        (["--movements", "0"], "must be 1 to 6000, not 0"),
        (["--idle", "soon"], "must be 1 to 86400 seconds, not soon"),
        (["--http", "x"], "'x' is not a port from 1 to 65535"),
        (["--allow-host", "tools.example.org"], "--allow-host and --allow-origin are for --http"),
        (["--http", "8766", "--token-file", "x"], "--token-file is not for --http: each caller shows a token of its"),
        (["--toolz", "say"], "--toolz is not known here; is it --tools?"),
    ],
)
def test_a_mistake_is_named(arguments: list[str], said: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        command.main(arguments)
    assert ended.value.code == 2
    told = capsys.readouterr()
    assert (told.out, said in told.err, told.err.count("\n")) == ("", True, 1), told.err


def test_a_port_that_is_taken_is_named(capsys: pytest.CaptureFixture[str]) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        assert command.main(["--http", str(port)]) == 1
    assert f"openrois mcp: cannot listen at 127.0.0.1:{port}: " in capsys.readouterr().err


def test_without_the_extra_it_says_what_installs_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "mcp_types", None)
    monkeypatch.setattr("openrois.extras.find_spec", lambda _name: None)
    with pytest.raises(MissingExtra, match=r"mcp_types is not installed: run `pip install 'openrois\[mcp\]'`"):
        command.main([])


LOADED = """
import sys
import openrois_agents.mcp.command, openrois_agents.mcp.stdio_server
heavy = {"openrois.catalog", "openrois.client", "openrois_agents.tools.session", "openrois_media", "numpy", "cv2"}
print(*sorted(heavy & set(sys.modules)))
"""


def test_before_it_greets_a_host_it_loads_no_client_and_no_media() -> None:
    done = subprocess.run([sys.executable, "-c", LOADED], capture_output=True, text=True, check=True, timeout=60)
    assert done.stdout == "\n"


def snippets() -> list[dict[str, Any]]:
    """Return what the guide gives to put into the files of hosts."""
    page = (ROOT / "docs" / "how-to" / "agents.md").read_text(encoding="utf-8")
    return [json.loads(each) for each in re.findall(r"```json\n(.*?)```", page, re.DOTALL)]


def test_what_the_guide_tells_hosts_to_run_can_be_run() -> None:
    begun = [
        server["args"]
        for snippet in snippets()
        for servers in snippet.values()
        for server in servers.values()
        if server.get("command") == "openrois"
    ]
    assert begun
    for name, *arguments in begun:
        assert name == "mcp"
        command._parser().parse_args(arguments)
