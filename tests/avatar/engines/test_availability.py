import ctypes
import importlib.util
import subprocess
import sys

import pytest
from openrois_avatar.engines import panda3d


def missing_library(name: str) -> None:
    raise OSError(f"{name}: cannot open shared object file")


def test_panda3d_without_its_package_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    assert panda3d.available() == (False, "Panda3D is not installed: pip install 'openrois[panda3d]'")


def test_panda3d_without_x11_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: object())
    monkeypatch.setattr(ctypes, "CDLL", missing_library)
    monkeypatch.setattr(sys, "platform", "linux")
    assert panda3d.available() == (False, "Panda3D needs the system library libX11.so.6: apt install libx11-6")


def test_panda3d_is_available_where_both_are_there(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: object())
    monkeypatch.setattr(ctypes, "CDLL", lambda name: object())
    assert panda3d.available() == (True, "")


def test_elsewhere_than_on_linux_no_library_is_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: object())
    monkeypatch.setattr(ctypes, "CDLL", missing_library)
    monkeypatch.setattr(sys, "platform", "darwin")
    assert panda3d.available() == (True, "")


def test_asking_imports_no_renderer() -> None:
    asking = "import sys; from openrois_avatar.engines.panda3d import available; available()"
    script = f"{asking}; print('panda3d' in sys.modules)"
    answer = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=20, check=True)
    assert answer.stdout == "False\n"
