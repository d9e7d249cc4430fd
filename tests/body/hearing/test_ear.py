import asyncio

import numpy as np
from openrois_body.hearing.ear import GONE, Ear
from openrois_streaming.source.source import RawAudio

from tests.support.hearing import stereo_48k, voice
from tests.support.listening import Listened

MONO = stereo_48k(voice(0.1))


async def test_sound_is_passed_on_and_silence_follows_its_end() -> None:
    listened = Listened()
    ear = Ear(listened.microphone, listened.clock)
    heard: list[RawAudio] = []
    leave = ear.listen(heard.append)
    async with listened.plugged(asyncio.ensure_future(ear.run())):
        await listened.say(MONO)
        assert (np.concatenate([sound.samples for sound in heard]) == MONO).all()
        await listened.clock.advance(GONE - 0.1)
        assert len(heard) == 10
        await listened.clock.advance(0.2)
        assert len(heard) == 11
        assert heard[-1].samples.shape == (48_000, 2)
        assert not heard[-1].samples.any()
        assert abs(heard[-1].captured_at - 1000.1) < 1e-6
        await listened.clock.advance(60)
        assert len(heard) == 11
        await listened.say(MONO)
        assert len(heard) == 21
        leave()
        leave()
        await listened.say(MONO)
        assert len(heard) == 21


async def test_channels_that_differ_are_two() -> None:
    listened = Listened()
    ear = Ear(listened.microphone, listened.clock)
    async with listened.plugged(asyncio.ensure_future(ear.run())):
        await listened.say(np.zeros((480, 2), np.int16))
        assert ear.channels == 0
        await listened.say(MONO)
        assert ear.channels == 1
        await listened.say(np.column_stack([MONO[:, 0], np.roll(MONO[:, 0], 3)]))
        assert ear.channels == 2
        await listened.say(MONO)
        assert ear.channels == 2
        listened.unplug()
        await listened.clock.advance(1.0)
        assert ear.channels == 0
