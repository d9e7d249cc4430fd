"""A backup of what gateways share is made while they run, and restored later, by the commands of the page."""

import asyncio
import os
import re
import signal
import subprocess
from pathlib import Path

import pytest

from tests.support.cluster_site import cluster_site
from tests.support.packages import ROOT
from tests.support.postgres import PASSWORD, Server, programs

pytestmark = [pytest.mark.usefixtures("haproxy", "nats"), pytest.mark.timeout(300)]

PAGE = (ROOT / "docs/how-to/several-gateways.md").read_text(encoding="utf-8")


def run_of_page(program: str, server: Server, dump: Path) -> None:
    """Run one command of the page, for this server and another file."""
    (line,) = re.findall(rf"^    runuser -u postgres -- ({program} .*)$", PAGE, re.MULTILINE)
    folder = programs()
    assert folder is not None
    name, *words = line.replace("/var/lib/postgresql/openrois.dump", str(dump)).split()
    # The database is the last one that it names, and has another name here.
    words = [
        "postgres" if number and words[number - 1] != "-n" and word == "openrois" else word
        for number, word in enumerate(words)
    ]
    where = ["-h", str(Path(server.socket).parent), "-U", "openrois"]
    environment = {**os.environ, "PGPASSWORD": PASSWORD}
    subprocess.run([folder / name, *where, *words], env=environment, check=True)


@pytest.mark.long
async def test_a_backup_that_is_restored_is_older_than_what_adapters_have_seen(
    postgres_server: Server, tmp_path: Path
) -> None:
    dump = tmp_path / "dump"
    async with cluster_site(0, postgres_server, tmp_path, may_forget=True) as here:
        await here.crowd()
        await asyncio.to_thread(run_of_page, "pg_dump", postgres_server, dump)
        await here.turns(0.3)
        first = await here.cluster.owner("robot0")
        await first.kill()
        await here.all_move()
        for gateway in here.cluster.others(first.gateway_id):
            gateway.signal(signal.SIGTERM)
        for gateway in here.cluster.others(first.gateway_id):
            assert await gateway.ended() == 0
        await asyncio.to_thread(run_of_page, "pg_restore", postgres_server, dump)
        for gateway in here.cluster.gateways.values():
            await gateway.start()
        for gateway in here.cluster.gateways.values():
            await gateway.ready()
        await here.all_move()
