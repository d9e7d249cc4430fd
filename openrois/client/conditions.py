"""Conditions, written so that no text can be taken for more than a text."""

__all__ = ["where"]


def where(**properties: str) -> str:
    """Return the condition that each property equals its text: `where(component_ref="robot/navigation")`.

    `component_ref` and `component_type` (a URN) are what a gateway knows. Conditions are joined by ` AND `.
    """
    return " AND ".join(f"{name} = '{text.replace(chr(39), chr(39) * 2)}'" for name, text in properties.items())
