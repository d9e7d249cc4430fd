from pathlib import Path

import pytest
from openrois_streaming.testing.chromium import find_chromium


def test_a_browser_is_found_by_any_of_its_names(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    assert find_chromium() is None
    for name in ("google-chrome", "chromium"):
        program = tmp_path / name
        program.touch(0o755)
        assert find_chromium() == str(program)
