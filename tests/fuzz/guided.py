"""A coverage-guided fuzzer of one parser: `python tests/fuzz/guided.py TARGET FOLDER -runs=N`, a process of its own.

A target takes any bytes; it must return, in bounded words, whatever they are. libFuzzer mutates what reached new
branches, so it finds what random text does not. Seeds and a dictionary are put into FOLDER first. What it finds ends it
with 77 and stands in FOLDER.
"""

import sys
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import atheris

with atheris.instrument_imports(include=["openrois"]):
    from openrois.catalog.streaming import VIDEO_STREAMING
    from openrois.condition import parse_condition
    from openrois.errors import BadParameter
    from openrois.jsonrpc.protocol import Notification, Peer, Request, Violation
    from openrois.profile_xml.parse import MalformedProfile
    from openrois.profile_xml.read import ComponentDocument, read_profile
    from openrois.profile_xml.write import component_xml, engine_xml
    from openrois.types.profiles import HRIEngineProfile, RoISIdentifier
    from openrois.types.values import check_value, decode_value, encode_value

PROPERTIES = frozenset({"component_ref", "component_type"})
TYPES = ("int", "double", "bool", "string", "DateTime", "Component_Status", "int[]", "double[][]", "string[]", "bool[]")


def protocol(data: bytes) -> None:
    """One message: what was understood can be answered, and an answer is never longer than it should be."""
    text = data.decode("utf-8", "replace")
    peer = Peer()
    peer.request("asked", {})
    match peer.receive(text):
        case Request() as request:
            peer.response(request.id, request.params)
        case Notification(name, params):
            peer.notification(name, params)
        case Violation(reason, answer):
            assert len(reason) < 300
            if answer is not None:
                answer.encode()


def condition(data: bytes) -> None:
    """One condition and a text to match it with."""
    text, _, value = data.decode("utf-8", "replace").partition("\x00")
    with suppress(BadParameter):
        parsed = parse_condition(text, PROPERTIES)
        parsed.matches({"component_ref": value, "component_type": text})
        assert len(parsed.comparisons) <= len(text)


def values(data: bytes) -> None:
    """One value of one type: what fits is read, and what was read is written so that it fits again."""
    if not data:
        return
    code, text = TYPES[data[0] % len(TYPES)], data[1:].decode("utf-8", "replace")
    with suppress(ValueError):
        check_value(code, text)
        read = decode_value(code, text)
        again = encode_value(code, read)
        check_value(code, again)
        assert decode_value(code, again) == read


def profile_xml(data: bytes) -> None:
    """One profile document: what is read can be written, and is then read as the same."""
    with suppress(MalformedProfile):
        document = read_profile(data)
        if isinstance(document, ComponentDocument):
            again = read_profile(component_xml(document.profile, document.component_ref))
        else:
            again = read_profile(engine_xml(document.profile))
        assert again.profile == document.profile


@dataclass(frozen=True)
class Target:
    """What is tried, where it begins, and the words that its language has."""

    run: Callable[[bytes], None]
    seeds: tuple[str, ...]
    words: tuple[str, ...]


TARGETS = {
    "protocol": Target(
        protocol,
        (
            '{"jsonrpc":"2.0","id":"req-1","method":"rois.system.connect","params":{}}',
            '{"jsonrpc":"2.0","id":1,"result":{"return_code":"OK"}}',
            '{"jsonrpc":"2.0","id":1,"error":{"code":-32601,"message":"Method not found","data":[]}}',
            '{"jsonrpc":"2.0","method":"rois.command.completed","params":{"command_id":"c1","status":"OK"}}',
            '[{"jsonrpc":"2.0","id":null,"method":"x"}]',
            '{"jsonrpc":"2.0","id":1e999,"method":"\\ud800","params":[NaN,-0,1.5]}',
        ),
        ('"jsonrpc"', '"2.0"', '"id"', '"method"', '"params"', '"result"', '"error"', '"code"', '"message"', "null"),
    ),
    "condition": Target(
        condition,
        (
            "component_ref = 'avatar/Reaction'\x00avatar/Reaction",
            "component_ref LIKE 'a%_\\\\%' AND \"component_type\" = 'it''s'\x00abc",
            " and  = '\x00",
        ),
        ("component_ref", "component_type", " AND ", " LIKE ", " = ", "''", "'", "%", "_", "\\\\", "\\x00"),
    ),
    "values": Target(
        values,
        (
            *(f"{chr(index)}{text}" for index in range(len(TYPES)) for text in ("-12", "1.5e-3", "true", "READY")),
            *(f"{chr(index)}{text}" for index in range(6, 10) for text in ("[1,2]", "[[1.5],[]]", '["a"]', "[true]")),
        ),
        ("true", "false", "READY", "[", "]", ",", "e", "-", ".", '\\"', "null", "1e400"),
    ),
    "profile_xml": Target(
        profile_xml,
        (
            component_xml(VIDEO_STREAMING.profile()),
            engine_xml(
                HRIEngineProfile(
                    identifier=RoISIdentifier(code="main"),
                    sub_profiles=(HRIEngineProfile(identifier=RoISIdentifier(code="a")),),
                    component_ids=("main/b c",),
                )
            ),
        ),
        (
            "rois:",
            "gml:id=",
            "<rois:HRIComponent>",
            "</",
            "/>",
            "xsi:type=",
            "&#10;",
            "&amp;",
            "<!DOCTYPE",
            "<![CDATA[",
        ),
    ),
}


def main() -> None:
    """Fuzz the target that the command line names."""
    target, folder = TARGETS[sys.argv[1]], Path(sys.argv[2])
    corpus, words = folder / "corpus", folder / "words"
    corpus.mkdir(parents=True)
    for index, seed in enumerate(target.seeds):
        (corpus / str(index)).write_bytes(seed.encode())
    words.write_text("".join('"{}"\n'.format(word.replace('"', '\\"')) for word in target.words))
    options = [f"-dict={words}", f"-artifact_prefix={folder}/", *sys.argv[3:]]
    atheris.Setup([sys.argv[0], *options, str(corpus)], target.run)
    atheris.Fuzz()


if __name__ == "__main__":
    main()
