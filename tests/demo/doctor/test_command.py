import json
from pathlib import Path

import pytest
from openrois_demo.doctor import command

pytestmark = pytest.mark.media


def test_streams_work_here(capsys: pytest.CaptureFixture[str]) -> None:
    assert command.main(["--interface", "127.0.0.1", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    found = {finding["name"]: finding for finding in told["findings"]}
    assert told["works"]
    assert found["media"]["level"] in ("ok", "warn")
    assert found["media"]["detail"].startswith("first picture after ")
    assert found["input"]["detail"].startswith("a key was there after ")
    assert found["vision"]["detail"].startswith("CascadeFinder, PatternRecognizer, HeadReader")


def test_they_do_not_without_a_way(capsys: pytest.CaptureFixture[str]) -> None:
    assert command.main(["--relay-only"]) == 1
    lines = capsys.readouterr().out.splitlines()
    assert any(line.startswith("fail  candidates") for line in lines)
    assert any(line.startswith("fail  media") for line in lines)
    assert lines[-1].endswith("streams will not work")


@pytest.mark.parametrize(
    "arguments",
    [
        ["--turn", "turn:t"],
        ["--turn", "turn:t", "--turn-secret-file", "nowhere"],
        ["--udp-ports", "1-2"],
        ["--port", "70000"],
    ],
)
def test_wrong_usage_ends_with_2(
    arguments: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as raised:
        command.main(arguments)
    assert raised.value.code == 2
    assert "openrois doctor: " in capsys.readouterr().err
