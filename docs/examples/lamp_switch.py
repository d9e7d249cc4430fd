"""Switches the lamp of `lamp_adapter.py` on, and says what it draws."""

import asyncio
import sys

from openrois.client import Client


async def main(url: str = "ws://127.0.0.1:8765/") -> None:
    """Bind the lamp, switch it on, and wait until it says that it was switched."""
    async with Client(url) as client:
        lamp = client.component("lamp_1/lamp")
        async with lamp.bound(), lamp.event("switched") as switched:
            await lamp.set_parameter(brightness=50)
            await lamp.command("switch", on=True)
            event = await anext(aiter(switched))
            power = await lamp.query("power")
            print(f"on: {event['on']}, {power['power']} W")


if __name__ == "__main__":
    asyncio.run(main(*sys.argv[1:]))
