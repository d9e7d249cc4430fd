"""Namespaces that tests make: what is of one process is not used by another."""

import subprocess
import sys

import ifaddr
import pytest

from tests.support.namespaces import namespace

_LISTING = """
import ifaddr
from tests.support.namespaces import hide_cables_of_others
hide_cables_of_others()
print([ip.ip for each in ifaddr.get_adapters() for ip in each.ips])
"""


@pytest.mark.usefixtures("namespaces")
def test_others_do_not_use_the_address_of_a_namespace() -> None:
    with namespace() as home:
        assert home.here in [ip.ip for each in ifaddr.get_adapters() for ip in each.ips]
        seen = subprocess.run([sys.executable, "-c", _LISTING], capture_output=True, text=True, check=True)
        assert home.here not in seen.stdout
