"""Profiles in files, as XML or as JSON."""

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Final

from pydantic import BaseModel, TypeAdapter, ValidationError

from openrois.profiles.xml.documents import Profiles
from openrois.profiles.xml.parse import MAX_SIZE
from openrois.profiles.xml.read import ComponentDocument, EngineDocument, read_profile
from openrois.types.messages import ProfileResult
from openrois.types.profiles import HRIComponentProfile, HRIEngineProfile

__all__ = [
    "documents_in",
    "json_text",
    "plain",
    "problem",
    "profile_files",
    "write_set",
]

_MAX_PATH: Final = 120
"""Characters of the path in an error."""

_SUFFIXES: Final = (".xml", ".json")
_LIST: Final = TypeAdapter(list[HRIComponentProfile])


def profile_files(path: Path) -> list[Path]:
    """Return the files of a path: itself, or all XML and JSON files of a directory.

    Raises:
        ValueError: it is a directory without any.
    """
    if not path.is_dir():
        return [path]
    found = sorted(each for each in path.rglob("*") if each.suffix.lower() in _SUFFIXES and each.is_file())
    if not found:
        raise ValueError(f"there is no XML or JSON file in {str(path)!r}")
    return found


def documents_in(path: Path) -> list[EngineDocument | ComponentDocument]:
    """Read a file: an XML document, or the JSON of a profile, of a list of them, or of what `get_profile` answers.

    Raises:
        OSError: it cannot be read.
        ValueError: it is no profile; the message says where and why.
    """
    with path.open("rb") as file:
        data = file.read(MAX_SIZE + 1)
    if not data.lstrip(b"\xef\xbb\xbf \t\r\n").startswith((b"{", b"[")):
        return [read_profile(data)]
    if len(data) > MAX_SIZE:
        raise ValueError(f"the file has more than {MAX_SIZE} bytes")
    try:
        found = list(_documents(_value(data)))
    except ValidationError as error:
        raise ValueError(problem(error)) from None
    if not found:
        raise ValueError("there is no profile in it")
    return found


def _value(data: bytes) -> Any:
    try:
        return json.loads(data)
    except json.JSONDecodeError as error:
        raise ValueError(f"line {error.lineno}: this is no JSON: {error.msg}") from None
    except UnicodeDecodeError:
        raise ValueError("this is no JSON: the text is not UTF-8") from None
    except RecursionError:
        raise ValueError("this is nested too deeply for a profile") from None
    except ValueError:
        # Python reads no integer of thousands of digits, which would take long.
        raise ValueError("a number in it has too many digits") from None


def _documents(value: Any) -> Iterator[EngineDocument | ComponentDocument]:
    if isinstance(value, list):
        for profile in _LIST.validate_python(value):
            yield ComponentDocument(profile)
    elif "component_profiles" in value or "profile" in value:
        result = ProfileResult.model_validate(value)
        if result.profile is not None:
            yield EngineDocument(result.profile)
        for component_ref, profile in result.component_profiles.items():
            yield ComponentDocument(profile, component_ref)
    elif "name" in value:
        yield ComponentDocument(HRIComponentProfile.model_validate(value))
    else:
        yield EngineDocument(HRIEngineProfile.model_validate(value))


def plain(profiles: Profiles) -> Any:
    """Return profiles as plain values for JSON: one alone as it is, types as a list, all else as `get_profile` does.

    Raises:
        ValueError: the profile of a type stands beside those of a system.
    """
    if profiles.types and (profiles.engine is not None or profiles.components):
        name = profiles.types[0].name
        raise ValueError(f"the profile of {name!r} is that of a type: its gml:id does not say whose it is")
    single = [*profiles.types, *profiles.components.values()] if profiles.engine is None else []
    if len(single) == 1:
        return single[0].model_dump(mode="json")
    if profiles.types:
        return [each.model_dump(mode="json") for each in profiles.types]
    # A document has each component once, with the engine nearest to it; on the wire every level lists it.
    engine = None if profiles.engine is None else profiles.engine.completed()
    result = ProfileResult(profile=engine, component_profiles=dict(profiles.components))
    return result.model_dump(mode="json", exclude={"return_code"})


def json_text(value: Any) -> str:
    """Return a value or model as JSON for people."""
    plain_value = value.model_dump(mode="json") if isinstance(value, BaseModel) else value
    text = json.dumps(plain_value, indent=2, ensure_ascii=False) + "\n"
    try:
        text.encode()
    except UnicodeEncodeError:
        # JSON can name half a surrogate pair, and UTF-8 cannot carry one.
        text = json.dumps(plain_value, indent=2) + "\n"
    return text


def write_set(directory: Path, documents: Mapping[str, str]) -> None:
    """Write documents into a directory, which is made where there is none.

    Raises:
        OSError: it cannot be written.
        ValueError: the directory is not empty: what stands there already could be taken for a part of the set.
    """
    if directory.is_dir() and any(directory.iterdir()):
        raise ValueError(f"the directory {str(directory)!r} is not empty")
    for name, text in documents.items():
        file = directory / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")


def problem(error: ValidationError) -> str:
    """Return the first problem: its dotted path, of a long one the end, and the message."""
    first = error.errors(include_url=False, include_context=False, include_input=False)[0]
    path = ".".join(str(part) for part in first["loc"])
    shown = path if len(path) <= _MAX_PATH else f"…{path[-_MAX_PATH:]}"
    return f"{shown}: {first['msg']}" if path else first["msg"]
