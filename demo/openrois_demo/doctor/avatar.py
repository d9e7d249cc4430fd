"""Findings about an avatar on this machine: its renderer, voice and senses. Needs `openrois[avatar]`."""

from collections.abc import Sequence
from importlib.util import find_spec

from openrois_avatar.engines.selection import NoGameEngine, choose_game_engine
from openrois_body.backends import Backend, chosen
from openrois_body.hearing.recognizer import RECOGNIZERS
from openrois_body.hearing.sphinx import Sphinx
from openrois_body.vision.backends import FINDERS, GESTURE_READERS
from openrois_body.vision.backends import RECOGNIZERS as FACE_RECOGNIZERS
from openrois_body.vision.cascades import CascadeFinder
from openrois_body.vision.head_reader import HeadReader
from openrois_body.vision.patterns import PatternRecognizer

from openrois.extras import install_command
from openrois_demo.doctor.finding import Finding, Level

__all__ = ["game_engine", "hearing", "vision", "voice"]


def game_engine() -> Finding:
    """Return the engine that would render the avatar."""
    try:
        name, missing = choose_game_engine("auto")
    except NoGameEngine as error:
        advice = f"{install_command('panda3d')} brings one; --engine synthetic shows a test picture without."
        return Finding(Level.WARN, "renderer", str(error), advice)
    return Finding(Level.WARN if missing else Level.OK, "renderer", name, missing)


def voice() -> Finding:
    """Check that the avatar can speak."""
    if find_spec("espeakng_loader") is not None:
        return Finding(Level.OK, "voice", "espeak-ng")
    return Finding(Level.WARN, "voice", "no espeak-ng: the avatar is mute", install_command("speech"))


def hearing() -> Finding:
    """Check that the avatar can recognise speech, and name its recogniser."""
    return _sense("hearing", "the avatar recognises no speech", (chosen(RECOGNIZERS, Sphinx),))


def vision() -> Finding:
    """Check that the avatar can see persons, and name what finds, recognises and reads them."""
    backends = (
        chosen(FINDERS, CascadeFinder),
        chosen(FACE_RECOGNIZERS, PatternRecognizer),
        chosen(GESTURE_READERS, HeadReader),
    )
    return _sense("vision", "the avatar sees no faces", backends)


def _sense(name: str, otherwise: str, backends: Sequence[Backend]) -> Finding:
    told = ", ".join(type(backend).__name__ for backend in backends)
    reasons = [reason for works, reason in (backend.available() for backend in backends) if not works]
    if not reasons:
        return Finding(Level.OK, name, told)
    return Finding(Level.WARN, name, f"{told}: {otherwise}", "; ".join(reasons))
