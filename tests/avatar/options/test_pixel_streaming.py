"""The options of Pixel Streaming."""

import argparse

import pytest
from openrois_avatar.options.pixel_streaming import PixelStreaming, add_pixel_streaming_options, pixel_streaming


def chosen(*arguments: str) -> PixelStreaming | None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--engine-id", default="avatar")
    add_pixel_streaming_options(parser)
    return pixel_streaming(parser.parse_args(arguments))


def test_the_avatar_is_no_streamer_unless_it_is_told_where() -> None:
    assert chosen() is None
    assert chosen("--pixel-streaming-input") is None


@pytest.mark.parametrize("host", ["127.0.0.1", "localhost", "[::1]"])
def test_a_signaling_server_is_on_this_machine(host: str) -> None:
    assert chosen("--pixel-streaming", f"ws://{host}:8888") == PixelStreaming(f"ws://{host}:8888", "avatar")


@pytest.mark.parametrize("host", ["10.0.0.1", "localhost.example.org", "example.org"])
def test_remote_server_has_to_be_allowed(host: str) -> None:
    with pytest.raises(ValueError, match="is not this machine"):
        chosen("--pixel-streaming", f"ws://{host}:8888")
    assert chosen("--pixel-streaming", f"wss://{host}", "--pixel-streaming-anywhere") is not None


@pytest.mark.parametrize(
    "url",
    [
        "8888",
        "http://127.0.0.1:8888",
        "ws://",
        "ws://127.0.0.1:99999",
        "ws://[1:8888",
        "ws://u:p@127.0.0.1",
        "ws://127.0.0.1#a",
    ],
)
def test_malformed_url_is_refused(url: str) -> None:
    with pytest.raises(ValueError, match="is no address of a signaling server"):
        chosen("--pixel-streaming", url)


def test_name_and_input_are_chosen() -> None:
    told = chosen("--pixel-streaming", "ws://127.0.0.1", "--pixel-streaming-id", "Ann", "--pixel-streaming-input")
    assert told == PixelStreaming("ws://127.0.0.1", "Ann", input=True)
