"""Running an adapter that streams: `run` and `serve` of `openrois.adapter`, with sources."""

import sys
from collections.abc import AsyncIterator, Mapping, Sequence
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Final

import cv2
from openrois_streaming.adaptation.viewer import Caps
from openrois_streaming.network.settings import NetworkSettings
from openrois_streaming.publish.encoder_limit import ENCODERS_LIMIT, EncoderLimit

from openrois import adapter
from openrois.component.component import Component
from openrois.session.session import EngineHost
from openrois_media.streams import AdapterStreams, Source, Stream

__all__ = ["prepare_process", "run", "serve"]

_SWITCH_INTERVAL: Final = 0.0005
"""Seconds after which a busy thread gives way: encoder threads must not keep the event loop waiting for 5 ms."""


def prepare_process() -> None:
    """Set what all threads of a process share for streaming."""
    sys.setswitchinterval(_SWITCH_INTERVAL)
    # Each picture is small and each encoder has a thread already: OpenCV's own threads would only wait for each other.
    cv2.setNumThreads(1)


@asynccontextmanager
async def serve(
    *components: Component,
    engine_id: str,
    streams: Mapping[str, Source | Stream],
    network: NetworkSettings | None = None,
    max_encoders: int = ENCODERS_LIMIT,
    max_viewer_bitrate: int | None = None,
    gateway: str | Sequence[str] | None = None,
    token_file: Path | str | None = None,
    ca_file: Path | str | None = None,
) -> AsyncIterator[EngineHost]:
    """Serve components and streams to a gateway while the block runs, and yield their engine.

        serve(engine_id="porch", streams={"camera": opencv_camera(0)})

    As with `run`, threads of this process give way after 0.5 ms (`sys.setswitchinterval`), so that encoders do not hold
    the event loop up, and OpenCV has no threads of its own (`cv2.setNumThreads(1)`). Both stay so after the block; a
    program that wants something else sets it inside.

    Args:
        components: besides the streaming components, each with a name of its own.
        engine_id: unique behind its gateway; leads every component_ref.
        streams: sources by the names of their components, `VideoStreaming` or `AudioStreaming` by what they give.
        network: addresses, ports and limits of the streams; unless given all addresses of this machine but loopback.
        max_encoders: encoders of all sources at a time; a source needs one for each codec and size that is watched.
        max_viewer_bitrate: bit/s that an application is sent at most of each stream; None: as much as its path carries.
        gateway: as in `openrois.adapter.serve`.
        token_file: likewise.
        ca_file: likewise.

    Raises:
        BadParameter: `engine_id` or a name cannot be part of a reference, or a name stands twice.
        TypeError: what is to be streamed is no source.
        ValueError: `gateway` is no address of a gateway, or a stream has two kinds of media.
        UnsupportedLibrary: the installed version of aiortc is not supported.
    """
    prepare_process()
    own = _streams(engine_id, streams, network, max_encoders, max_viewer_bitrate)
    async with adapter.serve(
        *own.components.values(),
        *components,
        engine_id=engine_id,
        gateway=gateway,
        token_file=token_file,
        ca_file=ca_file,
        extension=own,
    ) as host:
        yield host


def run(
    *components: Component,
    engine_id: str,
    streams: Mapping[str, Source | Stream],
    network: NetworkSettings | None = None,
    max_encoders: int = ENCODERS_LIMIT,
    max_viewer_bitrate: int | None = None,
    gateway: str | Sequence[str] | None = None,
    token_file: Path | str | None = None,
    ca_file: Path | str | None = None,
    verbose: bool = False,
) -> None:
    """Serve components and streams to a gateway until the process is told to stop (Ctrl-C, SIGTERM).

    It sets threads of the process as `serve` does.

    Args:
        components: as in `serve`.
        engine_id: likewise.
        streams: likewise.
        network: likewise.
        max_encoders: likewise.
        max_viewer_bitrate: likewise.
        gateway: as in `openrois.adapter.run`.
        token_file: likewise.
        ca_file: likewise.
        verbose: log more.

    Raises:
        BadParameter: `engine_id` or a name cannot be part of a reference, or a name stands twice.
        TypeError: what is to be streamed is no source.
        ValueError: `gateway` is no address of a gateway, or a stream has two kinds of media.
        SystemExit: what the environment names is none.
    """
    prepare_process()
    own = _streams(engine_id, streams, network, max_encoders, max_viewer_bitrate)
    adapter.run(
        *own.components.values(),
        *components,
        engine_id=engine_id,
        gateway=gateway,
        token_file=token_file,
        ca_file=ca_file,
        extension=own,
        verbose=verbose,
    )


def _streams(
    engine_id: str,
    streams: Mapping[str, Source | Stream],
    network: NetworkSettings | None,
    max_encoders: int,
    max_viewer_bitrate: int | None,
) -> AdapterStreams:
    if max_encoders < 1:
        raise ValueError(f"max_encoders must be 1 or more, not {max_encoders}")
    caps = Caps(max_bitrate=max_viewer_bitrate)
    limit = EncoderLimit(max_encoders)
    return AdapterStreams(engine_id, streams, network=network, cap=lambda _client: caps, encoders=limit)
