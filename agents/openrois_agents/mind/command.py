"""`openrois mind`: a conversation with whichever body is spoken to."""

import argparse
import asyncio
import os
import signal
import sys
from collections.abc import Collection, Sequence
from contextlib import AsyncExitStack
from dataclasses import dataclass
from typing import Final

from openrois.aio.supervisor import Supervisor
from openrois.aio.tasks import TaskScope
from openrois.cli.command_line import CommandLine
from openrois.extras import needing_extra
from openrois.observability.logs import set_up_logging
from openrois.transport.address import gateway_url
from openrois.transport.credential_options import add_credential_options, credentials
from openrois.transport.credentials import Credentials
from openrois_agents.mind.contract import Mind
from openrois_agents.mind.figures import MindFigures
from openrois_agents.mind.model.figures import ModelFigures
from openrois_agents.mind.options import MindChoice, add_mind_options, mind_choice

__all__ = ["main"]

_EPILOG: Final = """\
Without --llm-url it answers by rules, and understands the sentences of its grammar. It holds a body only while a
conversation lasts. Ctrl-C ends it.
"""


@dataclass(frozen=True, slots=True)
class _Chosen:
    """What the options say.

    Attributes:
        url: address of the gateway.
        shown: credentials that the gateway is shown.
        mind: what answers, and within which limits.
        metrics: host and port at which the figures are served; None where they are not served.
    """

    url: str
    shown: Credentials
    mind: MindChoice
    metrics: tuple[str, int] | None


def main(arguments: Sequence[str]) -> int:
    """Run the command and return its exit status: 0 when stopped, 1 when it could not start, 2 for wrong usage."""
    parser = CommandLine(
        "openrois mind",
        description="Lets bodies converse with their visitors.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--gateway", default="ws://127.0.0.1:8765/", metavar="URL", help="the gateway (%(default)s)")
    add_credential_options(parser)
    add_mind_options(parser)
    parser.add_argument(
        "--metrics", metavar="[HOST:]PORT", help="serve figures for Prometheus there, at /metrics; nowhere unless given"
    )
    parser.add_argument("--verbose", action="store_true", help="log more")
    chosen = parser.parse_args(arguments)
    try:
        read = _Chosen(
            gateway_url(chosen.gateway),
            credentials(chosen),
            mind_choice(chosen),
            _metrics_choice(chosen.metrics),
        )
    except ValueError as error:
        parser.error(str(error))
    set_up_logging(verbose=chosen.verbose)
    return asyncio.run(_until_stopped(read))


def _metrics_choice(text: str | None) -> tuple[str, int] | None:
    if text is None:
        return None
    with needing_extra("gateway"):
        from openrois.metrics.server import metrics_address
    return metrics_address(text)


async def _until_stopped(chosen: _Chosen) -> int:
    from openrois.client import ConnectionFailed, ConnectionLost, RoISError, RpcError

    running = asyncio.ensure_future(_converse(chosen))
    for name in (signal.SIGINT, signal.SIGTERM):
        asyncio.get_running_loop().add_signal_handler(name, running.cancel)
    try:
        return await running
    except asyncio.CancelledError:
        return 0
    except (ConnectionFailed, ConnectionLost, RoISError, RpcError, TimeoutError) as error:
        print(f"openrois mind: {error or 'the gateway does not answer'}", file=sys.stderr)
    return 1


async def _converse(chosen: _Chosen) -> int:
    from openrois.client import Client
    from openrois_agents.mind.conversation import Conversations
    from openrois_agents.mind.ears import Ears
    from openrois_agents.mind.phrases import Phrases, make_phrases
    from openrois_agents.tools.names import Vocabulary
    from openrois_agents.tools.session import Session
    from openrois_agents.tools.settings import ToolSettings

    figures = MindFigures()
    mind, model = _mind(chosen)

    def make_client() -> Client:
        return Client(chosen.url, token=chosen.shown.token, ca_file=chosen.shown.ca_file)

    async with AsyncExitStack() as stack:
        if chosen.metrics is not None and not await _serve(stack, chosen.metrics, figures, model):
            return 1
        await stack.enter_async_context(mind)
        session = await stack.enter_async_context(Session(make_client, ToolSettings()))
        wake_word = chosen.mind.wake_word

        def expected(names: Vocabulary, unknown: Collection[str]) -> Phrases:
            return make_phrases(names, wake_word=wake_word, unknown=unknown)

        conversations = Conversations(session, mind, chosen.mind.budget, figures, wake_word, lambda: ears.examples)
        ears = Ears(session, conversations.hear, expected if chosen.mind.model is None else None)
        await stack.enter_async_context(ears)
        print(f"ready {chosen.url}", flush=True)
        tasks = await stack.enter_async_context(TaskScope())
        tasks.start(_tell_supervisor(chosen.url))
        await conversations.run()
    return 0


async def _tell_supervisor(url: str) -> None:
    supervisor = Supervisor(os.environ)
    supervisor.notify_state(f"READY=1\nSTATUS=converses at {url}")
    await supervisor.watch()


def _mind(chosen: _Chosen) -> tuple[Mind, ModelFigures | None]:
    """Return what answers, and the figures of its model where it has one."""
    from openrois_agents.mind.rules import RuleMind

    if chosen.mind.model is None:
        return RuleMind(chosen.mind.wake_word), None
    from openrois_agents.mind.model.model_mind import ModelMind

    mind = ModelMind(chosen.mind.model, chosen.mind.budget)
    return mind, mind.figures


async def _serve(
    stack: AsyncExitStack, metrics: tuple[str, int], figures: MindFigures, model: ModelFigures | None
) -> bool:
    """Serve figures; return whether that is so."""
    with needing_extra("gateway"):
        from openrois.metrics.server import MetricsUnavailable
    from openrois_agents.mind.serving import serving_figures

    try:
        address = await stack.enter_async_context(serving_figures(*metrics, figures, model))
    except MetricsUnavailable as error:
        print(f"openrois mind: {error}", file=sys.stderr)
        return False
    print(f"figures {address}", flush=True)
    return True
