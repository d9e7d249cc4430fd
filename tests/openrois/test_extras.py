"""What is said where a library of an extra is missing."""

import subprocess
import sys

import pytest

from openrois.cli.__main__ import main
from openrois.extras import EXTRAS, MissingExtra, missing_modules, name_missing_extra, needing_extra


def test_the_smallest_extra_is_named_that_brings_the_module(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "aiohttp", None)
    error = ModuleNotFoundError("No module named 'aiohttp'", name="aiohttp.web")
    assert name_missing_extra(error) == "aiohttp is not installed: run `pip install 'openrois[gateway]'`"
    assert name_missing_extra(error, "avatar") == "aiohttp is not installed: run `pip install 'openrois[avatar]'`"
    assert name_missing_extra(error, "streaming") == "aiohttp is not installed: run `pip install 'openrois[gateway]'`"


@pytest.mark.parametrize(
    "error",
    [
        ImportError("libGL.so.1: cannot open shared object file", name="cv2"),
        ModuleNotFoundError("No module named 'lamp'", name="lamp"),
        ModuleNotFoundError("no name"),
        # It is installed; one of its parts is not, which no extra brings.
        ModuleNotFoundError("No module named 'pydantic.gone'", name="pydantic.gone"),
    ],
)
def test_another_reason_is_left_as_it_is(error: ImportError) -> None:
    assert name_missing_extra(error) is None


def test_a_library_that_is_there_and_lacks_a_part_is_left_as_it_is() -> None:
    assert name_missing_extra(ModuleNotFoundError("No module named 'aiohttp.gone'", name="aiohttp.gone")) is None


def test_an_import_says_which_extra_it_needs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "prometheus_client", None)
    said = r"^prometheus_client is not installed: run `pip install 'openrois\[gateway\]'`$"
    with pytest.raises(MissingExtra, match=said), needing_extra("gateway"):
        import prometheus_client  # noqa: F401
    with pytest.raises(ModuleNotFoundError, match=r"^No module named 'openrois\.gone'$"), needing_extra("gateway"):
        import openrois.gone  # type: ignore[import-not-found]  # noqa: F401


def test_what_is_missing_of_an_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    assert missing_modules("gateway") == ()
    monkeypatch.setitem(sys.modules, "jwt", None)
    assert missing_modules("gateway") == ("jwt",)
    assert missing_modules("avatar") == ()
    assert set(missing_modules("demo")) <= set(EXTRAS["demo"])


def test_what_needs_unix_says_so_on_windows(monkeypatch: pytest.MonkeyPatch) -> None:
    error = ModuleNotFoundError("No module named 'resource'", name="resource")
    assert name_missing_extra(error, "gateway") is None
    monkeypatch.setattr(sys, "platform", "win32")
    said = name_missing_extra(error, "gateway")
    assert said == "this runs on Linux and macOS; client, adapter and testing tools run on Windows too"


def test_a_command_says_in_one_sentence_what_it_lacks() -> None:
    # In a process of its own: what is imported anew here would be a second copy for the tests that follow.
    program = (
        "import sys; sys.modules['uvloop'] = None; from openrois.cli.__main__ import main; sys.exit(main(['gateway']))"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 1
    assert done.stderr == "openrois gateway: uvloop is not installed: run `pip install 'openrois[gateway]'`\n"


def test_a_command_that_cannot_be_imported_for_another_reason_says_that(monkeypatch: pytest.MonkeyPatch) -> None:
    def load(_entry: object) -> None:
        raise ImportError("libGL.so.1: cannot open shared object file", name="cv2")

    monkeypatch.setattr("importlib.metadata.EntryPoint.load", load)
    with pytest.raises(ImportError, match="libGL"):
        main(["avatar"])
