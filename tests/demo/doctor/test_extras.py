"""What the doctor says where extras are missing: every one of them with its command, and nothing that needs them."""

import sys

import pytest
from openrois_demo.doctor import command
from openrois_demo.doctor.extras import PURPOSES, extras
from openrois_demo.doctor.finding import Level

from openrois.extras import EXTRAS

pytestmark = pytest.mark.extra(name="base")


def test_every_extra_has_a_purpose() -> None:
    assert list(PURPOSES) == list(EXTRAS)


def test_it_names_what_is_missing_and_what_installs_it(monkeypatch: pytest.MonkeyPatch) -> None:
    for modules in EXTRAS.values():
        for name in modules:
            monkeypatch.setitem(sys.modules, name, None)
    found = list(extras())
    assert [(each.name, each.advice) for each in found] == [
        (f"extra {extra}", f"pip install 'openrois[{extra}]'") for extra in EXTRAS
    ]
    assert [each.name for each in found if each.level is Level.FAIL] == ["extra streaming"]
    assert found[0].detail.startswith("no gateway and no tokens: aiohttp, cryptography, ")


def test_without_them_it_looks_at_the_rest(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setitem(sys.modules, "aiortc", None)
    assert command.main(["--interface", "nowhere"]) == 1
    lines = capsys.readouterr().out.splitlines()
    assert any("aiortc" in line and line.startswith("fail  extra streaming") for line in lines)
    assert any("pip install 'openrois[streaming]'" in line for line in lines)
    assert any("clock" in line for line in lines)
    assert not any("candidates" in line or "renderer" in line for line in lines)
    assert lines[-1].endswith("streams will not work")
