"""`openrois avatar`: run an avatar adapter until a signal stops it."""

import argparse
import sys
from collections.abc import Sequence
from contextlib import AsyncExitStack

import uvloop
from openrois_body.speech.contract import DEFAULT_SYNTHESIZER
from openrois_body.speech_options import (
    EarsChoice,
    VoiceChoice,
    add_ears_options,
    add_voice_options,
    ears_choice,
    voice_choice,
)
from openrois_media.network_options import add_network_options, network_settings
from openrois_media.process import serve_process
from openrois_media.running import prepare_process
from openrois_streaming.adaptation.rung import MIN_BITRATE
from openrois_streaming.aiortc_internals.trial import UnsupportedLibrary

from openrois.adapter.loading import add_component_option, load_components
from openrois.adapter.process import run_until_stopped
from openrois.cli.command_line import CommandLine
from openrois.errors import BadParameter
from openrois.metrics.server import LOOPBACK, MetricsUnavailable, metrics_address
from openrois.observability.logs import set_up_logging
from openrois.transport.address import adapter_urls
from openrois.transport.credential_options import add_credential_options, credentials
from openrois_avatar.adapter import Avatar, run_avatar
from openrois_avatar.check import command as check
from openrois_avatar.engines.selection import NoGameEngine
from openrois_avatar.facades.running import FACADES, FacadeAvatar, run_facade
from openrois_avatar.facades.server import FacadeUnavailable
from openrois_avatar.link.messages import LinkError
from openrois_avatar.options.engine_options import add_engine_options, engine_arguments
from openrois_avatar.options.link_options import add_facade_option, add_link_options, link_secret
from openrois_avatar.options.pixel_streaming import add_pixel_streaming_options, pixel_streaming
from openrois_avatar.options.settings import AvatarSettings

__all__ = ["main"]


def main(arguments: Sequence[str]) -> int:
    """Run the command and return its exit status: 0 when stopped, 1 when it could not start, 2 for wrong usage."""
    if arguments[:1] == ["check"]:
        return check.main(arguments[1:])
    defaults = AvatarSettings()
    parser = CommandLine(
        "openrois avatar",
        description="An avatar behind a gateway.",
        epilog="`openrois avatar check --help`: try a game engine of your own.",
    )
    parser.add_argument(
        "--gateway",
        default=",".join(defaults.gateways),
        metavar="URL[,URL]",
        help="where it is, or each of several (%(default)s)",
    )
    add_credential_options(parser)
    parser.add_argument("--engine-id", default=defaults.engine_id, help="unique behind its gateway (%(default)s)")
    add_engine_options(parser)
    add_link_options(parser, when=" if it is external or a facade")
    add_facade_option(parser)
    parser.add_argument(
        "--metrics",
        metavar="[HOST:]PORT",
        help=f"serve figures for Prometheus there, at /metrics (without it nowhere; HOST is {LOOPBACK} unless given)",
    )
    parser.add_argument(
        "--max-viewer-bitrate",
        type=_bitrate,
        metavar="BIT/S",
        help="that an application is sent at most of each video stream (as much as its path carries)",
    )
    parser.add_argument(
        "--max-encoders",
        type=_encoders,
        default=defaults.max_encoders,
        metavar="N",
        help="encoders of the picture at a time; viewers then share what runs (%(default)s)",
    )
    add_component_option(parser)
    add_voice_options(parser)
    add_ears_options(parser)
    add_network_options(parser)
    add_pixel_streaming_options(parser)
    parser.add_argument("--verbose", action="store_true", help="log more")
    parser.add_argument("--log-format", choices=("text", "json"), default="text", help="of log lines (%(default)s)")
    chosen = parser.parse_args(arguments)
    try:
        engine_arguments(chosen)
        gateways = adapter_urls(chosen.gateway)
        metrics = None if chosen.metrics is None else metrics_address(chosen.metrics)
        network = network_settings(chosen)
        secret = link_secret(chosen)
        voice, ears, components = voice_choice(chosen), ears_choice(chosen), load_components(chosen.own_components)
        _refuse_speech(chosen, voice, ears)
        streamer = pixel_streaming(chosen)
        if streamer is not None and chosen.engine in FACADES:
            raise ValueError(
                f"--pixel-streaming cannot be used with --engine {chosen.engine}: its pictures do not pass through the"
                " adapter"
            )
    except ValueError as error:
        parser.error(str(error))
    shown = credentials(chosen)
    try:
        # Both are read again whenever they are needed; an error now is most likely a mistake.
        shown.newest()
        for url in gateways:
            shown.context(url)
    except ValueError as error:
        print(f"openrois avatar: {error}", file=sys.stderr)
        return 1
    set_up_logging(verbose=chosen.verbose, form=chosen.log_format)
    prepare_process()
    settings = AvatarSettings(
        gateways,
        chosen.engine_id,
        chosen.engine,
        chosen.stamp,
        chosen.size,
        chosen.visitor,
        link=chosen.link,
        facade=chosen.facade,
        link_secret=secret,
        metrics=metrics,
        network=network,
        max_viewer_bitrate=chosen.max_viewer_bitrate,
        max_encoders=chosen.max_encoders,
        pixel_streaming=streamer,
        credentials=shown,
        voice=voice,
        ears=ears,
        components=components,
    )
    try:
        uvloop.run(run_until_stopped(_serve(settings)))
    except (NoGameEngine, LinkError, UnsupportedLibrary, BadParameter, FacadeUnavailable, MetricsUnavailable) as error:
        print(f"openrois avatar: {error}", file=sys.stderr)
        return 1
    return 0


def _refuse_speech(chosen: argparse.Namespace, voice: VoiceChoice, ears: EarsChoice) -> None:
    """Refuse what is said of voice and ears where the adapter has none."""
    if voice.name != DEFAULT_SYNTHESIZER and (chosen.engine in FACADES or chosen.engine == "synthetic"):
        raise ValueError(
            f"--voice {voice.name} cannot be used with --engine {chosen.engine}, which has no voice of ours"
        )
    if ears.name and chosen.engine in FACADES:
        raise ValueError(
            f"--ears {ears.name} cannot be used with --engine {chosen.engine}: sound does not pass through the adapter"
        )


def _bitrate(text: str) -> int:
    if not (text.isascii() and text.isdigit()) or int(text) < MIN_BITRATE:
        raise argparse.ArgumentTypeError(f"must be an integer of at least {MIN_BITRATE} bit/s, not {text!r}")
    return int(text)


def _encoders(text: str) -> int:
    if not (text.isascii() and text.isdigit()) or int(text) < 1:
        raise argparse.ArgumentTypeError(f"must be an integer of at least 1, not {text!r}")
    return int(text)


async def _serve(settings: AvatarSettings) -> None:
    async with AsyncExitStack() as stack:
        avatar: Avatar | FacadeAvatar
        if settings.engine in FACADES:
            avatar = await stack.enter_async_context(run_facade(settings))
        else:
            avatar = await stack.enter_async_context(run_avatar(settings))
        await serve_process(
            avatar.host, settings.gateways, settings.credentials, avatar.collect_figures, settings.metrics
        )
