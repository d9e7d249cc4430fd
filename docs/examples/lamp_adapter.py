"""A lamp behind a gateway: run it, and Ctrl-C ends it."""

from openrois.adapter import Component, command, event, main, parameter, query


class Lamp(Component, authority="Example", function="actuation"):
    """A lamp that can be dimmed."""

    brightness: int = parameter(80, description="per cent")
    is_on = False

    @command
    async def switch(self, on: bool) -> None:
        """Switch the lamp on or off."""
        self.is_on = on
        self.switched(on)

    @query
    async def power(self) -> float:
        """Return the watts that it draws."""
        return 0.06 * self.brightness if self.is_on else 0.0

    @event
    def switched(self, on: bool) -> None:
        """The lamp was switched on or off."""


if __name__ == "__main__":
    main(Lamp("lamp"), engine_id="lamp_1")
