"""`openrois bench`: measure what matters on this machine, and say under which conditions."""

from collections.abc import Sequence

from openrois_streaming.testing.chromium import find_chromium

from openrois.cli.command_line import CommandLine
from openrois_bench.faults.stop import StopSettings, run_stop
from openrois_bench.options import add_gateway_benches, add_json, carry_out, count, report_progress, seconds
from openrois_bench.streams.fanout.bench import FanoutSettings, run_fanout
from openrois_bench.streams.latency.bench import LatencySettings, run_latency

__all__ = ["main"]


def main(arguments: Sequence[str]) -> int:
    """Run the command and return its exit status.

    Returns:
        0 when it measured, 1 when it could not, 2 for wrong usage, 130 when it was interrupted.
    """
    parser = CommandLine("openrois bench", description="Measures on this machine.")
    benches = parser.add_subparsers(dest="bench", required=True, metavar="BENCH")
    latency, fanout, stop = LatencySettings(), FanoutSettings(), StopSettings()
    told = "from capture to viewer, over gateway and adapter: a measuring sink, and Chromium if there is one (a minute)"
    options = benches.add_parser("latency", help=told, description=told)
    options.add_argument(
        "--seconds", type=seconds, default=latency.seconds, help="that each viewer plays (%(default)s)"
    )
    options.add_argument("--runs", type=count, default=latency.runs, help="of connecting and resuming (%(default)s)")
    add_json(options)
    options.set_defaults(
        loop_factory=None,
        run=lambda chosen: run_latency(
            LatencySettings(chosen.seconds, chosen.runs, chromium=find_chromium()), report_progress
        ),
    )
    told = "the sender's CPU with 1 to 8 viewers, beside aiortc alone (about 80 s)"
    options = benches.add_parser("fanout", help=told, description=told)
    options.add_argument("--seconds", type=seconds, default=fanout.seconds, help="of each run (%(default)s)")
    options.add_argument("--rounds", type=count, default=fanout.rounds, help="of all runs (%(default)s)")
    add_json(options)
    options.set_defaults(
        loop_factory=None, run=lambda chosen: run_fanout(FanoutSettings(chosen.seconds, chosen.rounds), report_progress)
    )
    told = "STOP and a dead man's switch beside viewers that flood the engine with datagrams (two and a half minutes)"
    options = benches.add_parser("stop", help=told, description=told)
    options.add_argument("--engine", choices=("synthetic",), default=stop.engine, help="what is shown (%(default)s)")
    options.add_argument("--seconds", type=seconds, default=stop.seconds, help="under each load (%(default)s)")
    options.add_argument("--dead-man", type=count, default=stop.dead_man, help="tries under each load (%(default)s)")
    add_json(options)
    options.set_defaults(
        loop_factory=None,
        run=lambda chosen: run_stop(
            StopSettings(chosen.seconds, chosen.dead_man, engine=chosen.engine), report_progress
        ),
    )
    add_gateway_benches(benches)
    return carry_out(parser.parse_args(arguments))
