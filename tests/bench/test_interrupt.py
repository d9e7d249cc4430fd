import asyncio
import signal
import sys
from asyncio.subprocess import PIPE

import psutil
import pytest

COMMAND = "import sys; from openrois_bench.command import main; sys.exit(main(sys.argv[1:]))"


@pytest.mark.media
@pytest.mark.long
@pytest.mark.parametrize(
    ("bench", "begun"), [("latency", b"640x360: sink"), ("fanout", b"connecting 8 viewers to each of 4 senders")]
)
async def test_ctrl_c_leaves_no_process_behind(bench: str, begun: bytes) -> None:
    process = await asyncio.create_subprocess_exec(
        sys.executable, "-c", COMMAND, bench, stdout=PIPE, stderr=PIPE, start_new_session=True
    )
    try:
        async with asyncio.timeout(60):
            assert process.stderr is not None
            while begun not in (line := await process.stderr.readline()):
                assert line, "it ended"
            children = psutil.Process(process.pid).children(recursive=True)
            process.send_signal(signal.SIGINT)
            out, _ = await process.communicate()
    finally:
        if process.returncode is None:
            process.kill()
    assert process.returncode == 130
    assert out == b""
    assert len(children) >= 2
    gone, alive = await asyncio.to_thread(psutil.wait_procs, children, timeout=3)
    assert len(gone) == len(children)
    assert alive == []
