"""Which modules are pure, and which tests must run every branch of them: `tests/branches.py` counts."""

import tomllib
from pathlib import Path

import pytest

from tests.support.packages import ROOT, packages

# Whole processes and sockets are others' business: what is pure is tested by itself.
TESTS = (
    *(
        f"tests/openrois/{part}"
        for part in (
            *("aio", "catalog", "commands", "component", "engine", "jsonrpc", "leases"),
            *("observability", "profiles/xml", "scope", "session", "types"),
        )
    ),
    *(f"tests/openrois/gateway/test_{part}.py" for part in ("origins", "stalling")),
    "tests/openrois/http_limits/test_websocket_frames.py",
    "tests/openrois/transport/test_backoff.py",
    "tests/openrois/bench/test_figures.py",
    "tests/openrois/bench/test_table.py",
    "tests/openrois/journal/test_former.py",
    *(
        f"tests/openrois/auth/test_{part}.py"
        for part in ("claims", "keys", "loopback", "principal", "revocations", "subject_quotas", "tokens")
    ),
    *(
        f"tests/conformance_command/test_{part}.py"
        for part in ("command_ids", "manifest", "probe_engine", "strictness", "table")
    ),
    *(str(path.relative_to(ROOT)) for path in sorted((ROOT / "tests/openrois").glob("test_*.py"))),
    *(f"tests/streaming/test_{part}.py" for part in ("state", "liveness")),
    *(f"tests/streaming/source/test_{part}.py" for part in ("loudness", "supervision")),
    *(f"tests/streaming/publish/test_{part}.py" for part in ("encoder_health", "encoder_limit", "key_frames")),
    "tests/streaming/network/test_places.py",
    "tests/streaming/peer/test_arrival.py",
    "tests/streaming/publish/test_reference_chain.py",
    "tests/streaming/adaptation",
    "tests/streaming/input",
    "tests/streaming/rtp",
    "tests/streaming/send/test_probe.py",
    *(
        str(path.relative_to(ROOT))
        for path in sorted((ROOT / "tests/streaming/receive").glob("test_*.py"))
        if path.stem not in {"test_decoders", "test_sources"}
    ),
    *(
        f"tests/streaming/testing/test_{part}.py"
        for part in ("candidates", "clicks", "delays", "link", "lipsync", "pictures", "sounds")
    ),
    *(
        f"tests/streaming/network/test_{part}.py"
        for part in ("admission", "datagrams", "guard", "policy", "servers", "settings")
    ),
    *(
        str(path.relative_to(ROOT))
        for path in sorted((ROOT / "tests/codegen").glob("test_*.py"))
        if "csharp" not in path.name
    ),
    "tests/avatar/doctor/test_finding.py",
    *(
        f"tests/avatar/hearing/test_{part}.py"
        for part in (
            *("bearing", "dictionary", "downsample", "jsgf"),
            *("noise_floor", "presence", "voice_activity", "voice_frames"),
        )
    ),
    "tests/avatar/engines/animation/test_gait.py",
    "tests/avatar/engines/room",
    "tests/avatar/teleoperation/test_steering.py",
    "tests/avatar/test_engine_sound.py",
    "tests/avatar/sensing",
    "tests/avatar/motion",
    *(f"tests/avatar/pixel_streaming/test_{part}.py" for part in ("conversation", "hands", "protocol", "settings")),
    *(f"tests/avatar/vision/test_{part}.py" for part in ("box", "gallery", "head_gestures", "seen", "tracks")),
    *(f"tests/avatar/facades/test_{part}.py" for part in ("messages", "sections", "streamers", "viewing")),
    "tests/avatar/test_health.py",
    "tests/avatar/test_sound_lag.py",
    "tests/avatar/test_world.py",
    "tests/avatar/speech/test_markup.py",
    "tests/avatar/speech/test_words.py",
    "tests/signaling",
    "tests/fuzz",
)


def pure_modules() -> list[str]:
    """Return what the import contract on pure modules lists: what does no input or output can be tested whole."""
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]["contracts"]
    (pure,) = (contract for contract in contracts if contract["name"] == "Pure modules do no input or output")
    return list(pure["source_modules"])


def files_of(module: str) -> list[str]:
    """Return the patterns of a module's files: its own, and those below it if it is a package."""
    package, _, rest = module.partition(".")
    (folder,) = (each for each in packages() if Path(each).name == package)
    path = f"{folder}/{rest.replace('.', '/')}".rstrip("/")
    return [f"{path}/*"] if (ROOT / path).is_dir() else [f"{path}.py"]


@pytest.mark.parametrize("path", TESTS)
def test_what_counts_is_there(path: str) -> None:
    assert (ROOT / path).exists()
