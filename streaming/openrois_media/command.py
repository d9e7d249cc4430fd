"""The command line of an adapter that streams: that of any adapter, and the network of its streams."""

from collections.abc import Mapping, Sequence

from openrois_streaming.publish.encoder_limit import ENCODERS_LIMIT

from openrois.adapter.command import adapter_options, read_options
from openrois.component.component import Component
from openrois_media.network_options import add_network_options, network_settings
from openrois_media.running import run
from openrois_media.streams import Source, Stream

__all__ = ["main"]


def main(
    *components: Component,
    engine_id: str,
    streams: Mapping[str, Source | Stream],
    max_encoders: int = ENCODERS_LIMIT,
    max_viewer_bitrate: int | None = None,
    arguments: Sequence[str] | None = None,
) -> None:
    """Serve components and streams as `run` does, with the options of the command line; `--help` lists them.

    Args:
        components: besides the streaming components, each with a name of its own.
        engine_id: unique behind its gateway; leads every component_ref, unless `--engine-id` names another.
        streams: sources by the names of their components.
        max_encoders: as in `run`.
        max_viewer_bitrate: likewise.
        arguments: of the command line; those of the process unless given.

    Raises:
        SystemExit: the options are wrong, or help was asked for.
    """
    parser = adapter_options(components, engine_id, also=tuple(streams))
    add_network_options(parser)
    chosen = read_options(parser, arguments)
    try:
        network = network_settings(chosen)
    except ValueError as error:
        parser.error(str(error))
    run(
        *components,
        engine_id=chosen.engine_id,
        streams=streams,
        network=network,
        max_encoders=max_encoders,
        max_viewer_bitrate=max_viewer_bitrate,
        gateway=chosen.gateway,
        token_file=chosen.token_file,
        ca_file=chosen.ca_file,
        verbose=chosen.verbose,
    )
