"""A component for any body: `openrois avatar --component greeter:Greeter`."""

from openrois_body.host_body import HostBody

from openrois.adapter import Component, ComponentStatus, command, event, query


class Greeter(Component, authority="Example", function="actuation"):
    """Greets persons by their names, and counts them."""

    def __init__(self, body: HostBody) -> None:
        super().__init__()
        self._voice = body.voice
        self._greeted = 0

    def condition(self) -> ComponentStatus:
        """Return READY where the body speaks."""
        speaks = self._voice is not None and self._voice.available()[0]
        return ComponentStatus.READY if speaks else ComponentStatus.ERROR

    @command
    async def greet(self, name: str) -> None:
        """Greet a person, and end when that was heard."""
        if self._voice is not None:
            await self._voice.say(f"Hello, {name}!", ssml=False, language="en", character="default", volume=80)
            self._greeted += 1
            self.greeted(name)

    @query(result="number")
    async def number_greeted(self) -> int:
        """Return how many were greeted."""
        return self._greeted

    @event
    def greeted(self, name: str) -> None:
        """A person was greeted."""
