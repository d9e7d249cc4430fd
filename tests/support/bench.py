"""Reports of benches that never ran."""

from openrois_bench.faults.stop_report import Load, StopReport
from openrois_bench.faults.stop_report import Run as StopRun
from openrois_bench.measuring.conditions import Conditions
from openrois_bench.measuring.figures import Percentiles
from openrois_bench.streams.fanout.report import FanoutReport
from openrois_bench.streams.fanout.runs import AIORTC, OPENROIS, Run, compare
from openrois_bench.streams.latency.report import LatencyReport
from openrois_bench.viewing.observation import Observation, Sightings

CONDITIONS = Conditions(
    cpus=2, processor="P", system="S", python="3", versions={"aiortc": "1"}, load_before=0.1, load_after=0.2
)


def observation(viewer: str, **milliseconds: tuple[float, ...]) -> Observation:
    seen = Sightings(width=640, height=360, numbers=(1, 2, 4), unreadable=0, milliseconds=milliseconds)
    return Observation.of(viewer, "video/H264", seen)


def latency(*observations: Observation) -> LatencyReport:
    return LatencyReport(conditions=CONDITIONS, seconds=0.5, runs=2, observations=observations)


def fanout(*, delivered: bool, others: float | None = None) -> FanoutReport:
    runs = [
        Run(
            round=0,
            codec="video/VP8",
            viewers=2,
            way=way,
            cpu=cpu,
            encoders=encoders,
            fps=(fps, 30.0),
            kbps=1000,
            delivered=fps > 27,
            others=others,
        )
        for way, cpu, encoders, fps in ((OPENROIS, 0.1, 1, 30.0), (AIORTC, 0.4, 2, 29.6 if delivered else 3.0))
    ]
    return FanoutReport(conditions=CONDITIONS, seconds=1, rounds=1, comparisons=compare(runs), runs=tuple(runs))


def stop_run(load: Load, p99: float = 20.0, **more: object) -> StopRun:
    """A run under a load, of which everything was there unless `more` says otherwise."""
    reached = {"reports": load.reports, "strangers": load.strangers, "joined": load.viewers}
    waits = Percentiles(count=300, p50=4_000.0, p95=9_000.0, p99=p99 * 1000)
    rest = {"unconfirmed": 0, "adapter": 0.2, "pictures": 30.0}
    return StopRun.model_validate({"load": load, "stops": waits, **rest, **reached, **more})


def stop(*runs: StopRun) -> StopReport:
    return StopReport(engine="synthetic", conditions=CONDITIONS, seconds=20, pinned=True, runs=runs)
