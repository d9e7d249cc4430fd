import ctypes
import importlib.util
import shutil
import subprocess
import sys

import pytest
from openrois_avatar.engines import godot, panda3d


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


def test_godot_that_is_missing_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shutil, "which", lambda name: None)
    works, hint = godot.available()
    assert not works
    assert hint == "Godot 3 is not found (godot3-runner or godot3); run `apt install godot3-runner`"


def test_godot_without_a_display_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shutil, "which", {"godot3": "/usr/bin/godot3"}.get)
    monkeypatch.delenv("DISPLAY", raising=False)
    works, hint = godot.available()
    assert not works
    assert hint.endswith("`apt install xvfb`")
    monkeypatch.setenv("DISPLAY", ":0")
    assert godot.available() == (True, "")
    assert godot.program() == "/usr/bin/godot3"


def test_the_godot_project_is_where_it_is_looked_for() -> None:
    assert (godot.project() / "project.godot").is_file()
