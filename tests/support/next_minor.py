"""The program of the next minor version, as far as that may differ from this one (docs/reference/versions.md).

    python -m tests.support.next_minor gateway ...

No such version exists yet: this is the real program of this one with another number, with one more version of the
tables, which it writes, and with more in each result, notification and greeting of its own.
"""

import json
import sys
from functools import partial
from typing import Any, Final
from unittest.mock import patch

import openrois.cluster.frames as frames
import openrois.cluster.postgres.database as database
import openrois.cluster.postgres.ownership as ownership
import openrois.cluster.postgres.stop_messages as stop_messages
import openrois.cluster.pulse as pulse
import openrois.federation.neighbours as neighbours
import openrois.gateway.cluster_parts as cluster_parts
from openrois.cli.__main__ import main
from openrois.cluster.postgres.schema import STEPS, Step, migrate, migrate_back
from openrois.federation.assertion import Assertion
from openrois.version import __version__
from tests.support.newer import speaking_newer, with_more

__all__ = ["NEXT_MINOR", "NEXT_VERSION", "WRITER"]

_MAJOR, _MINOR = map(int, __version__.split(".")[:2])

NEXT_VERSION: Final = f"{_MAJOR}.{_MINOR + 1}.0"

NEXT_MINOR: Final = (sys.executable, "-m", "tests.support.next_minor")
"""The program of a gateway."""

WRITER: Final = "written_by"
"""The column of claims that the next version adds, and writes its number into."""

_STEPS: Final = (
    *STEPS,
    Step(
        forward=f"""
            ALTER TABLE openrois.claim ADD COLUMN {WRITER} text;
            ALTER TABLE openrois.gateway ADD COLUMN colour text NOT NULL DEFAULT 'red';
            ALTER TABLE openrois.resume_line ADD COLUMN colour text NOT NULL DEFAULT 'red';
            ALTER TABLE openrois.holding ADD COLUMN colour text;
            ALTER TABLE openrois.command ADD COLUMN colour text NOT NULL DEFAULT 'red';
            CREATE TABLE openrois.colour (name text PRIMARY KEY);
            CREATE INDEX claim_by_gateway ON openrois.claim (gateway_id);
        """,
        back=f"""
            DROP INDEX openrois.claim_by_gateway;
            DROP TABLE openrois.colour;
            ALTER TABLE openrois.command DROP COLUMN colour;
            ALTER TABLE openrois.holding DROP COLUMN colour;
            ALTER TABLE openrois.resume_line DROP COLUMN colour;
            ALTER TABLE openrois.gateway DROP COLUMN colour;
            ALTER TABLE openrois.claim DROP COLUMN {WRITER};
        """,
    ),
)


def _written_claim() -> str:
    """Return the statement that writes a claim, with the number of the version that did."""
    given = ownership._WRITE
    for former, latter in (
        ("instance, first_epoch)\n", f"instance, first_epoch, {WRITER})\n"),
        ("$4::bigint\n", f"$4::bigint, '{NEXT_VERSION}'\n"),
        ("= excluded.first_epoch\n", f"= excluded.first_epoch, {WRITER} = excluded.{WRITER}\n"),
    ):
        assert given.count(former) == 1, former
        given = given.replace(former, latter)
    return given


def _say_more() -> None:
    said, hello, written = frames._Said.model_dump_json, Assertion.hello, stop_messages._written

    def said_with_more(model: Any, **options: Any) -> str:
        return json.dumps(with_more(json.loads(said(model, **options))))

    patch.object(frames._Said, "model_dump_json", said_with_more).start()
    patch.object(Assertion, "hello", lambda assertion: with_more(hello(assertion))).start()
    patch.object(stop_messages, "_written", lambda value: written(with_more(value))).start()
    speaking_newer().start()


def _run() -> int:
    for module in (pulse, neighbours, sys.modules["openrois.cli.__main__"]):
        patch.object(module, "__version__", NEXT_VERSION).start()
    patch.object(ownership, "_WRITE", _written_claim()).start()
    patch.object(database, "migrate", partial(migrate, steps=_STEPS)).start()
    patch.object(cluster_parts, "migrate_back", partial(migrate_back, steps=_STEPS)).start()
    _say_more()
    return main()


if __name__ == "__main__":
    sys.exit(_run())
