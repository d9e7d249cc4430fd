"""Tasks, rates, listeners and bounded memory for asyncio programs; nothing here knows RoIS or a wire."""
