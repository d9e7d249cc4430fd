"""An adapter as the process that it will be, behind a real gateway."""

import asyncio
import os
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

from openrois.adapter.running import GATEWAY_VARIABLE
from openrois.extras import needing_extra

if TYPE_CHECKING:
    from openrois.gateway.server import Gateway

__all__ = ["launched"]


@asynccontextmanager
async def launched(*program: str, patience: float = 20.0) -> AsyncIterator["Gateway"]:
    """Run an adapter's program behind a gateway on a port of its own, and yield the gateway once the adapter is there.

    The adapter finds the gateway by the environment, as one does that calls `run` without an address. In the end it is
    stopped, and has to end.

    Args:
        program: the program and its arguments, such as `sys.executable, "lamp_adapter.py"`.
        patience: seconds that it has to begin and to end.

    Raises:
        TimeoutError: it did not connect, or did not stop.
        RuntimeError: it ended by itself.
        MissingExtra: the libraries of a gateway are not installed here (`openrois[gateway]`).
    """
    with needing_extra("gateway"):
        from openrois.gateway.server import run_gateway
        from openrois.gateway.settings import GatewaySettings
    async with run_gateway(GatewaySettings(port=0)) as gateway:
        changed = asyncio.Event()
        stop_listening = gateway.engine.on_change(changed.set)
        address = f"{gateway.url.replace('http', 'ws', 1)}adapter"
        process = await asyncio.create_subprocess_exec(*program, env={**os.environ, GATEWAY_VARIABLE: address})
        ended = asyncio.ensure_future(process.wait())
        attached = asyncio.ensure_future(changed.wait())
        try:
            async with asyncio.timeout(patience):
                await asyncio.wait({ended, attached}, return_when=asyncio.FIRST_COMPLETED)
            if ended.done():
                raise RuntimeError(f"{program} ended with exit status {ended.result()}")
            stop_listening()
            yield gateway
        finally:
            attached.cancel()
            if process.returncode is None:
                process.terminate()
            try:
                async with asyncio.timeout(patience):
                    await asyncio.shield(ended)
            except TimeoutError:
                process.kill()
                await ended
                raise
