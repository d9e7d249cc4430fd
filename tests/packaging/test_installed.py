"""The product as users install it: a wheel in a virtual environment of its own, alone and with each extra.

Each environment is filled from the package index, which takes up to a minute: one of them is made in every run, and the
others are `long`.
"""

from pathlib import Path
from typing import Final

import pytest

from openrois.extras import EXTRAS
from openrois.version import __version__
from tests.support.installations import TEST_TOOLS, Installation, files_marked_for, installed_size, new_installation
from tests.support.once import once, shared_folder

pytestmark = pytest.mark.timeout(600)

LARGEST: Final = 66_000_000
"""Bytes that an environment with the product alone may take."""

LAZY: Final = """
import sys
import openrois.adapter, openrois.client, openrois.testing
libraries = {"aiohttp", "aiortc", "av", "cv2", "jwt", "numpy", "prometheus_client", "uvloop"}
sys.exit(f"imported: {libraries & set(sys.modules)}" if libraries & set(sys.modules) else 0)
"""

IN_MEMORY: Final = """
import asyncio
from openrois.adapter import Component, command
from openrois.testing import MissingExtra, harness, launched

class Lamp(Component, authority="Example", function="actuation"):
    @command
    async def switch(self, on: bool) -> None:
        self.is_on = on

async def main():
    lamp = Lamp("lamp")
    async with harness(lamp) as client:
        proxy = client.component("robot/lamp")
        async with proxy.bound():
            await client.run(proxy.command("switch", on=True))
    assert lamp.is_on
    try:
        async with launched("true"):
            pass
    except MissingExtra as error:
        print(error)

asyncio.run(main())
"""


@pytest.fixture(scope="module")
def plain(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Installation:
    """The product alone, which the workers of a run have in common."""
    shared = shared_folder(tmp_path_factory, "installations")
    return Installation(once(shared / "alone", lambda folder: Installation.new(folder).install_product(wheel)))


def test_the_product_alone_is_small(plain: Installation) -> None:
    size = installed_size(plain.folder)
    print(f"{size / 1e6:.1f} MB")
    assert size <= LARGEST


def test_applications_and_adapters_import_nothing_of_an_extra(plain: Installation) -> None:
    done = plain.run("python", "-c", LAZY)
    assert done.returncode == 0, done.stderr


def test_a_component_is_tried_in_memory(plain: Installation) -> None:
    done = plain.run("python", "-c", IN_MEMORY)
    assert done.returncode == 0, done.stderr
    assert done.stdout == "aiohttp is not installed: run `pip install 'openrois[gateway]'`\n"


def test_the_commands_of_the_product_alone_work(plain: Installation) -> None:
    assert plain.run("openrois", "--version").stdout == f"openrois {__version__}\n"
    listed = plain.run("openrois", "--help")
    assert "  gateway      run a gateway" in listed.stdout
    assert "shall" in plain.run("openrois", "conformance").stdout
    assert "<" in plain.run("openrois", "profile", "export", "--type", "Navigation").stdout


def test_the_doctor_names_every_extra_with_its_command(plain: Installation) -> None:
    done = plain.run("openrois", "doctor")
    assert done.returncode == 1, done.stderr
    for extra in EXTRAS:
        assert f" extra {extra} " in done.stdout
        assert f"pip install 'openrois[{extra}]'\n" in done.stdout
    assert done.stderr == ""


def test_a_command_of_an_extra_names_it(plain: Installation) -> None:
    for command, extra in {"gateway": "gateway", "token": "gateway", "avatar": "avatar", "demo": "demo"}.items():
        done = plain.run("openrois", command, "--help")
        assert (done.returncode, done.stdout) == (1, "")
        assert done.stderr.startswith(f"openrois {command}: ")
        assert done.stderr.endswith(f" is not installed: run `pip install 'openrois[{extra}]'`\n")
        assert done.stderr.count("\n") == 1


@pytest.mark.long
@pytest.mark.parametrize("extra", ["base", *EXTRAS, "dev"])
def test_an_extra_is_all_that_its_tests_need(extra: str, wheel: Path) -> None:
    assert files_marked_for(extra), f"no test is marked for {extra}"
    with new_installation() as installation:
        installation.install_product(wheel, "" if extra == "base" else extra)
        size = installed_size(installation.folder)
        installation.install(*TEST_TOOLS)
        done = installation.run_tests(extra)
    print(f"{extra}: {size / 1e6:.0f} MB; {done.stdout.splitlines()[-1]}")
    assert done.returncode == 0, done.stdout[-6000:] + done.stderr[-2000:]
    assert "skipped" not in done.stdout.splitlines()[-1], done.stdout[-3000:]
