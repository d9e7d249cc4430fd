"""A Reachy Mini over the vendor's own daemon, whose robot is a mock-up: run by `make robots`."""

import pytest
from openrois_body.speech.synthesizer import Synthesizer
from openrois_robots.reachy.adapter import hosted_reachy
from openrois_robots.reachy.daemon.rest import Daemon, DaemonUnreachable
from openrois_robots.reachy.postures.gestures import GESTURES, SLEEPING
from openrois_robots.reachy.voice import wave_file
from openrois_streaming.clock import SystemClock

from openrois.errors import ComponentFailed
from openrois.testing import findings
from tests.robots.reachy.behaviour_suite import BehaviourSuite
from tests.robots.reachy.daemon_suite import DaemonSuite
from tests.robots.reachy.process_suite import ProcessSuite
from tests.support.reachy import linked
from tests.support.vendor_daemon import VendorDaemon

pytestmark = pytest.mark.robots


class _Vendors:
    """The daemon of all tests."""

    @pytest.fixture
    def daemon(self, vendor_daemon: VendorDaemon) -> VendorDaemon:
        return vendor_daemon


class TestVendorDaemon(_Vendors, DaemonSuite):
    pass


class TestBehaviour(_Vendors, BehaviourSuite):
    gestures = tuple(name for name in GESTURES if name != SLEEPING)


class TestProcess(_Vendors, ProcessSuite):
    pass


class TestSound(_Vendors):
    async def test_a_sound_of_ours_is_taken_and_removed(self, daemon: VendorDaemon) -> None:
        async with Synthesizer() as synthesizer, Daemon(daemon.address) as api:
            data = wave_file(await synthesizer.synthesize("Hello, I am a Reachy Mini."))
            await api.upload_sound("openrois-test.wav", data)
            assert "openrois-test.wav" in (await api.get("/api/media/sounds"))["files"]
            await api.delete("/api/media/sounds/openrois-test.wav")

    async def test_what_is_no_sound_is_refused_with_the_daemons_reason(self, daemon: VendorDaemon) -> None:
        async with Daemon(daemon.address) as api:
            with pytest.raises(ComponentFailed, match="failed: Unsupported or invalid audio file"):
                await api.upload_sound("openrois-test.wav", b"not a sound")

    async def test_a_name_of_the_internet_is_refused_with_what_to_do(self, daemon: VendorDaemon) -> None:
        async with Daemon(daemon.address) as api:
            api.session.headers["Host"] = "reachy.example.org"
            with pytest.raises(DaemonUnreachable, match=r"takes an IP address or a name that ends in \.local only"):
                await api.get("/api/daemon/status")


class TestContract(_Vendors):
    async def test_every_component_that_can_work_keeps_the_contract(self, daemon: VendorDaemon) -> None:
        clock = SystemClock()
        async with linked(daemon.address, "reachy") as robot, hosted_reachy("reachy", robot, clock) as running:
            if robot.state.motor_problem():
                await robot.state.daemon.post("/api/motors/set_mode/enabled")
                await robot.state.refresh()
            parameters = {
                "reachy/reaction": {"reaction_ref": "urn:x-rois:def:reaction:OMG::1"},
                "reachy/move": {"line": "[0,10]"},
            }
            found = await findings(running.host.engine, parameters=parameters, patience=20.0)
        absent = ("reachy/sound_localizer", "reachy/speech_synthesizer")
        assert [each for each in found if each.component_ref not in absent] == []
