"""Two channels of what an application sends: browsers send one unless the offer asks for two (RFC 7587 section 6.1)."""

import re
from collections.abc import Sequence

_OPUS = re.compile(r"(?m)^a=rtpmap:(\d+) opus/48000/2\r\n")


def with_stereo(sdp: str, wanted: Sequence[bool]) -> str:
    """Return `sdp` with its m-sections asking for two channels of Opus where that is `wanted`."""
    session, *sections = re.split(r"(?m)^(?=m=)", sdp)
    changed = [_asking(section) if want else section for section, want in zip(sections, wanted, strict=True)]
    return "".join((session, *changed))


def _asking(section: str) -> str:
    found = _OPUS.search(section)
    if found is None:
        return section
    parameters = re.compile(rf"(?m)^(a=fmtp:{found[1]} [^\r\n]*)")
    if parameters.search(section):
        return parameters.sub(r"\1;stereo=1", section)
    return f"{section[: found.end()]}a=fmtp:{found[1]} stereo=1\r\n{section[found.end() :]}"
