"""Answers and failures of tools as results of the protocol."""

import base64

from mcp_types import CallToolResult, ContentBlock, ImageContent, TextContent

from openrois_agents.tools.answer import Answer

__all__ = ["answered", "failed"]


def answered(answer: Answer) -> CallToolResult:
    """Return the result for an answer."""
    content: list[ContentBlock] = [TextContent(text=answer.text)]
    if answer.picture:
        content.append(ImageContent(data=base64.b64encode(answer.picture).decode(), mime_type="image/jpeg"))
    return CallToolResult(content=content, structured_content=answer.data)


def failed(kind: str, sentence: str) -> CallToolResult:
    """Return the result for a failure, which a language model reads, and may do something about."""
    return CallToolResult(content=[TextContent(text=sentence)], structured_content={"error": kind}, is_error=True)
