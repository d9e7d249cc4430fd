"""Importing the product does nothing: no connection, no listener, no program, for any of its modules."""

import subprocess
import sys

from tests.support.installations import APART
from tests.support.kachaka_api import needs_kachaka
from tests.support.packages import ROOT, packages

IMPORTING = """
import importlib, sys

def refuse(event, arguments):
    if event.startswith("socket.") and event not in HARMLESS or event in FORBIDDEN:
        raise PermissionError(f"{event} {arguments}")

HARMLESS = {"socket.gethostname"}
FORBIDDEN = {"subprocess.Popen", "os.system", "os.exec", "os.posix_spawn", "os.fork", "urllib.Request"}
sys.addaudithook(refuse)
for name in sys.argv[1:]:
    importlib.import_module(name)
print(len(sys.argv) - 1)
"""


def modules() -> list[str]:
    """Return the dotted name of every module; those that are programs are not imported by anybody."""
    found = []
    for package in packages():
        folder = ROOT / package
        for path in sorted(folder.rglob("*.py")):
            parts = path.relative_to(folder.parent).with_suffix("").parts
            # What needs libraries with versions of their own is tried beside them: `make agents`.
            if parts[-1] != "__main__" and not APART.keys() & set(parts):
                found.append(".".join(part for part in parts if part != "__init__"))
    return found


@needs_kachaka
def test_no_module_reaches_for_the_network_or_starts_a_program() -> None:
    names = modules()
    said = subprocess.run([sys.executable, "-c", IMPORTING, *names], capture_output=True, text=True, check=False)
    assert said.returncode == 0, said.stderr[-2000:]
    assert said.stdout.splitlines()[-1] == str(len(names))


def test_it_would_be_seen() -> None:
    for wrong in ("socket.socket()", "subprocess.run(['true'])", "socket.getaddrinfo('localhost', 1)"):
        program = f"{IMPORTING}\nimport socket, subprocess\n{wrong}"
        said = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
        assert "PermissionError" in said.stderr, wrong
