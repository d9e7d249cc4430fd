"""F43: a configuration or a certificate that is damaged, at the start and while the gateway runs."""

import random
import time
from pathlib import Path

import pytest

from openrois.gateway.configuration import configure
from openrois.gateway.encryption import Certificate
from tests.support.certificates import Authority
from tests.support.ground import ground, program, turns
from tests.support.seeds import ALL, SOME

_SHIPPED = Path(__file__).parents[2] / "packaging" / "gateway.toml"
_TRIES = 40


def damaged(whole: bytes, chance: random.Random) -> bytes:
    """Cut a file off, write over it, or put something in between, as a full disk or a bad copy does."""
    data, at = bytearray(whole), chance.randrange(len(whole))
    match chance.randrange(4):
        case 0:
            return cut(whole, chance)
        case 1:
            data[at : at + chance.randrange(1, 64)] = chance.randbytes(chance.randrange(64))
        case 2:
            data[at] ^= 1 << chance.randrange(8)
        case 3:
            data[at:at] = bytes(data[: chance.randrange(len(data))])
    return bytes(data)


def cut(whole: bytes, chance: random.Random) -> bytes:
    """Cut a file off, within its last line at the latest."""
    return whole[: chance.randrange(len(whole) - 20)]


@pytest.mark.parametrize("seed", ALL)
def test_f43_a_damaged_configuration_is_refused_with_one_line(seed: int, tmp_path: Path) -> None:
    chance, file = random.Random(seed), tmp_path / "gateway.toml"
    refusals: list[str] = []
    # The files that it names are not here; so what it would set beside them is left out.
    lines = _SHIPPED.read_bytes().splitlines(keepends=True)
    whole = b"".join(line for line in lines if b"_file" not in line and b"tls_" not in line)
    for _ in range(_TRIES):
        file.write_bytes(damaged(whole, chance))
        try:
            configure(["--config", str(file)], {})
        except ValueError as error:
            refusals.append(str(error))
    assert refusals
    assert not [text for text in refusals if "\n" in text or "Traceback" in text]


@pytest.mark.parametrize("seed", ALL)
def test_f43_a_damaged_certificate_is_refused_with_one_line(seed: int, tmp_path: Path) -> None:
    chance, authority = random.Random(seed), Authority(tmp_path)
    cert, key = authority.issue()
    whole = {file: file.read_bytes() for file in (cert, key)}
    refusals: list[tuple[str, Path]] = []
    for _ in range(_TRIES):
        for file, data in whole.items():
            file.write_bytes(data)
        file = chance.choice((cert, key))
        file.write_bytes(damaged(whole[file], chance))
        try:
            Certificate(cert, key, time.time)
        except ValueError as error:
            refusals.append((str(error), file))
    assert refusals
    assert not [text for text, file in refusals if "\n" in text or str(file) not in text]


@pytest.mark.parametrize("seed", SOME)
async def test_f43_a_gateway_with_a_bad_file_does_not_start(seed: int, tmp_path: Path) -> None:
    chance, authority = random.Random(seed), Authority(tmp_path)
    cert, key = authority.issue()
    bad = (cert, key)[seed % 2]
    bad.write_bytes(bad.read_bytes()[: chance.randrange(200)])
    options = ("--port", "0", "--tls-cert", str(cert), "--tls-key", str(key))
    async with program("-m", "openrois.cli", "gateway", *options, log=tmp_path / "gateway.log") as gateway:
        assert await gateway.ended() != 0
        (line,) = gateway.log().splitlines()
        assert str(bad) in line


@pytest.mark.parametrize("seed", ALL)
async def test_f43_new_and_damaged_certificates_drop_no_connection(
    seed: int, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    authority = Authority(tmp_path)
    cert, key = authority.issue()
    async with ground(seed, tmp_path, caplog, tls=authority.context(), tls_cert=cert, tls_key=key) as place:
        app = await place.witness()
        for _ in range(6):
            authority.issue()
            if place.chance.random() < 0.5:
                # Whether the signature of an authority is whole can be told by those alone who know the authority.
                file, harm = place.chance.choice(((cert, cut), (key, damaged)))
                file.write_bytes(harm(file.read_bytes(), place.chance))
            place.gateway.reload()
            await turns(place.chance)
            assert await app.code("rois.system.get_profile", condition="") == "OK"
            newcomer = await place.witness()
            assert await newcomer.code("rois.system.get_profile", condition="") == "OK"
