"""Which modules are pure, and which tests must run every branch of them: `tests/branches.py` counts."""

import ast
import re
from functools import cache
from pathlib import Path

import pytest

from tests.support.imports import import_graph
from tests.support.packages import ROOT, modules, packages

IMPURE = frozenset(
    {
        *("asyncio", "socket", "threading", "subprocess", "time"),
        *("aiohttp", "websockets", "aiortc", "aioice", "av", "nats", "mcp"),
    }
)
"""What a pure module does not import, directly or by another module."""

# Whole processes and sockets are others' business: what is pure is tested by itself.
TESTS = (
    *(
        f"tests/openrois/{part}"
        for part in (
            *("aio", "catalog", "commands", "component", "engine", "jsonrpc", "leases", "ownership", "resumption"),
            *("observability", "profiles/xml", "scope", "session", "types"),
        )
    ),
    *(f"tests/openrois/gateway/test_{part}.py" for part in ("origins", "stalling")),
    *(f"tests/openrois/cluster/test_{part}.py" for part in ("flow", "frames", "presence", "subjects", "wire")),
    *(f"tests/openrois/cluster/postgres/test_{part}.py" for part in ("address", "stop_messages")),
    *(
        f"tests/openrois/federation/test_{part}.py"
        for part in ("assertion", "destinations", "foreign_work", "shared_quotas", "version_skew")
    ),
    "tests/openrois/adapter/test_rotation.py",
    "tests/openrois/http_limits/test_websocket_frames.py",
    "tests/openrois/transport/test_backoff.py",
    "tests/bench/measuring/test_figures.py",
    "tests/bench/measuring/test_table.py",
    *(f"tests/openrois/journal/test_{part}.py" for part in ("former", "records")),
    *(
        f"tests/openrois/auth/test_{part}.py"
        for part in ("claims", "keys", "loopback", "principal", "ranks", "revocations", "subject_quotas", "tokens")
    ),
    *(
        f"tests/conformance_command/test_{part}.py"
        for part in ("command_ids", "manifest", "probe_engine", "strictness", "table")
    ),
    *(str(path.relative_to(ROOT)) for path in sorted((ROOT / "tests/openrois").glob("test_*.py"))),
    *(f"tests/streaming/test_{part}.py" for part in ("state", "liveness")),
    *(f"tests/streaming/source/test_{part}.py" for part in ("downsample", "loudness", "supervision")),
    *(f"tests/streaming/publish/test_{part}.py" for part in ("encoder_health", "encoder_limit", "key_frames")),
    "tests/streaming/capture/test_given.py",
    "tests/streaming/network/test_session_limits.py",
    "tests/streaming/publish/test_reference_chain.py",
    "tests/streaming/adaptation",
    "tests/streaming/input",
    "tests/streaming/rtp",
    *(
        str(path.relative_to(ROOT))
        for path in sorted((ROOT / "tests/streaming/receive").glob("test_*.py"))
        if path.stem not in {"test_decoders", "test_sources"}
    ),
    *(
        f"tests/streaming/testing/test_{part}.py"
        for part in ("candidates", "delays", "link", "lipsync", "pictures", "sounds")
    ),
    *(f"tests/streaming/network/test_{part}.py" for part in ("admission", "guard", "policy", "servers", "settings")),
    *(
        str(path.relative_to(ROOT))
        for path in sorted((ROOT / "tests/codegen").glob("test_*.py"))
        if "csharp" not in path.name
    ),
    "tests/demo/doctor/test_finding.py",
    "tests/avatar/link/test_messages.py",
    "tests/avatar/options/test_pixel_streaming.py",
    *(
        f"tests/body/hearing/test_{part}.py"
        for part in (
            *("bearing", "dictionary", "jsgf", "likeness"),
            *("noise_floor", "voice_activity", "voice_frames"),
        )
    ),
    "tests/avatar/engines/animation/test_gait.py",
    "tests/avatar/engines/room",
    "tests/body/teleoperation/test_steering.py",
    "tests/body/sound/test_engine_sound.py",
    "tests/body/processes/test_framing.py",
    "tests/body/speech/test_lips.py",
    "tests/body/speech/test_mouth.py",
    "tests/body/services/test_address.py",
    "tests/body/services/test_events.py",
    "tests/body/speech/test_pcm.py",
    "tests/body/speech/test_resample.py",
    "tests/body/speech/test_visemes.py",
    "tests/body/sensing",
    *(f"tests/body/motion/test_{part}.py" for part in ("approach", "ground", "moves", "planning", "targets")),
    *(f"tests/avatar/pixel_streaming/test_{part}.py" for part in ("conversation", "player_input", "protocol")),
    *(f"tests/body/vision/test_{part}.py" for part in ("box", "gallery", "head_gestures", "sighting", "tracks")),
    *(
        f"tests/avatar/facades/test_{part}.py"
        for part in ("messages", "sections", "streamers", "session", "session_negotiation")
    ),
    "tests/agents/tools",
    *(f"tests/agents/mind/test_{part}.py" for part in ("limits", "phrases", "placing", "replies")),
    "tests/agents/mind/model",
    *(f"tests/agents/mcp/test_{part}.py" for part in ("guard", "token_claims")),
    *(f"tests/robots/simulated/{part}" for part in ("test_battery.py", "test_driving.py", "world", "drawing")),
    *(f"tests/robots/ros2/test_{part}.py" for part in ("definitions", "matching", "names")),
    *(f"tests/robots/ros2/robot/test_{part}.py" for part in ("poses", "strokes")),
    "tests/robots/ros2/simulator/test_model.py",
    *(f"tests/robots/adapter/test_{part}.py" for part in ("battery", "image_files")),
    *(f"tests/robots/kachaka/test_{part}.py" for part in ("layout", "limits", "persons")),
    *(f"tests/robots/kachaka/api/test_{part}.py" for part in ("address", "tracking")),
    "tests/robots/kachaka/simulator/test_robot.py",
    "tests/robots/reachy/postures",
    "tests/robots/reachy/daemon/test_address.py",
    "tests/robots/reachy/simulator/test_model.py",
    "tests/media/test_health.py",
    "tests/body/motion/test_world.py",
    "tests/body/speech/test_markup.py",
    "tests/body/speech/test_words.py",
    "tests/signaling",
    "tests/fuzz",
)


@cache
def pure_modules() -> tuple[str, ...]:
    """Return the modules whose docstring says that they are pure; of a package that says so, all below it are."""
    found = []
    for path in modules():
        text = ast.get_docstring(ast.parse((ROOT / path).read_text(encoding="utf-8"))) or ""
        if re.search(r"\bPure[.:]|\ball modules are pure\b", text, re.IGNORECASE):
            # The folder of a package's distribution is no part of its name.
            name = path.removesuffix(".py").removesuffix("/__init__").replace("/", ".")
            found.append(name[name.index("openrois") :])
    return tuple(found)


def files_of(module: str) -> list[str]:
    """Return the patterns of a module's files: its own, and those below it if it is a package."""
    package, _, rest = module.partition(".")
    (folder,) = (each for each in packages() if Path(each).name == package)
    path = f"{folder}/{rest.replace('.', '/')}".rstrip("/")
    return [f"{path}/*"] if (ROOT / path).is_dir() else [f"{path}.py"]


def test_pure_modules_do_no_input_or_output() -> None:
    graph = import_graph()
    below = tuple(f"{each}." for each in pure_modules())
    pure = [each for each in graph.modules if each in pure_modules() or each.startswith(below)]
    found = {each: sorted(graph.find_upstream_modules(each) & IMPURE) for each in pure}
    assert len(pure) > 150
    assert {each: imports for each, imports in found.items() if imports} == {}


@pytest.mark.parametrize("path", TESTS)
def test_what_counts_is_there(path: str) -> None:
    assert (ROOT / path).exists()
