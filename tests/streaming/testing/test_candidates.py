import json

import pytest
from hypothesis import given
from hypothesis import strategies as st
from openrois_streaming.testing.candidates import addresses, rerouted

pytestmark = pytest.mark.extra(name="streaming")

RELAY = ("127.0.0.1", 4000)
OURS = "candidate:0 1 udp 2130706431 127.0.0.1 4000 typ host"
SDP = "\r\n".join(
    [
        "v=0",
        "o=- 1 1 IN IP4 0.0.0.0",
        "m=video 5000 UDP/TLS/RTP/SAVPF 96",
        "c=IN IP4 10.0.0.2",
        "a=candidate:1 1 udp 100 10.0.0.3 5001 typ host",
        "a=candidate:2 1 UDP 200 10.0.0.2 5000 typ host generation 0",
        "a=candidate:3 2 udp 300 10.0.0.2 5002 typ host",
        "a=candidate:4 1 tcp 300 10.0.0.2 9 typ host tcptype active",
        "a=candidate:5 1 udp 300 b.local 5003 typ host",
        "a=end-of-candidates",
        "m=audio 9 UDP/TLS/RTP/SAVPF 97",
        "c=IN IP6 ::1",
        "a=candidate:1 1 udp 100 fe80::1 5004 typ host",
        "m=audio 0 UDP/TLS/RTP/SAVPF 97",
        "",
    ]
)


def message(**params: object) -> str:
    return json.dumps({"jsonrpc": "2.0", "method": "signaling.offer", "params": params})


class TestAddresses:
    def test_the_best_comes_first_and_names_say_nothing(self) -> None:
        assert addresses(SDP) == [("10.0.0.2", 5000), ("10.0.0.3", 5001), ("fe80::1", 5004)]

    @pytest.mark.parametrize("line", [OURS, f"a={OURS}", message(candidate=OURS), message(sdp=f"v=0\n a={OURS}\n")])
    def test_a_candidate_alone_or_in_a_message(self, line: str) -> None:
        assert addresses(line) == [RELAY]

    @pytest.mark.parametrize(
        "text",
        ["", "candidate:", OURS.replace("4000", "0"), OURS.replace("4000", "99999"), "[1]", '{"params": 1}', "{", "{}"],
    )
    def test_others_have_none(self, text: str) -> None:
        assert addresses(text) == []

    def test_deep_nesting_is_no_message(self) -> None:
        assert addresses('{"a":' * 100_000) == []


class TestRerouted:
    def test_a_section_has_one_candidate_left(self) -> None:
        told = rerouted(SDP, RELAY)
        assert told.count("a=candidate:") == told.count(f"a={OURS}\r\n") == 2
        assert "10.0.0" not in told
        assert ".local" not in told
        assert "a=end-of-candidates\r\n" in told
        assert addresses(told) == [RELAY]

    def test_ports_and_addresses_of_connections_too(self) -> None:
        told = rerouted(SDP, RELAY)
        assert "m=video 4000 " in told
        assert "m=audio 9 " in told
        assert "m=audio 0 " in told
        assert told.count("c=IN IP4 127.0.0.1\r\n") == 2
        assert rerouted(SDP, ("::1", 4000)).count("c=IN IP6 ::1\r\n") == 2

    @pytest.mark.parametrize(
        "line",
        [
            "candidate:1 1 udp 1 b.local 1 typ host",
            "candidate:1 1 udp 1 10.1.1.1 1 typ srflx raddr 10.2.2.2 rport 7",
        ],
    )
    def test_a_candidate_alone(self, line: str) -> None:
        assert rerouted(line, RELAY) == OURS
        assert rerouted(f"a={line}", RELAY) == f"a={OURS}"

    def test_a_message(self) -> None:
        told = json.loads(rerouted(message(sdp=SDP, peer_id="p"), RELAY))
        assert told["params"] == {"sdp": rerouted(SDP, RELAY), "peer_id": "p"}
        assert told["method"] == "signaling.offer"
        told = json.loads(rerouted(message(candidate="candidate:1 1 udp 1 b.local 1 typ host"), RELAY))
        assert told["params"]["candidate"] == OURS

    @pytest.mark.parametrize("text", ["", "hello", '{"params": [1]}', message(candidate=None), message(text="none")])
    def test_others_pass(self, text: str) -> None:
        assert rerouted(text, RELAY) == text

    @given(st.text() | st.text("a=candite:19 .udp\r\nmc{}\"'", max_size=60))
    def test_whatever_it_is(self, text: str) -> None:
        told = rerouted(text, RELAY)
        assert rerouted(told, RELAY) == told
        assert set(addresses(told)) <= {RELAY} | set(addresses(text))
