"""Lets a body speak by the tools of `openrois mcp`, as a language model's host does: `agent_host.py [TEXT [URL]]`."""

import asyncio
import sys

from mcp import Client, StdioServerParameters


async def main(text: str = "Hello!", url: str = "ws://127.0.0.1:8765/") -> None:
    """Reserve whichever body is free, let it say the text, and give it back."""
    server = StdioServerParameters(command=sys.executable, args=["-m", "openrois.cli", "mcp", "--gateway", url])

    async def report(progress: float, total: float | None, message: str | None) -> None:
        print(f"{progress:.0f} s: {message}")

    async with Client(server) as host:
        tools = await host.list_tools()
        print("tools:", ", ".join(tool.name for tool in tools.tools))
        for name, arguments in (("use_body", {"tools": ["say"]}), ("say", {"text": text}), ("give_back", {})):
            result = await host.call_tool(name, arguments, progress_callback=report)
            print(
                name,
                "failed:" if result.is_error else "did:",
                *(each.text for each in result.content if each.type == "text"),
            )
            if result.is_error:
                return


if __name__ == "__main__":
    asyncio.run(main(*sys.argv[1:]))
