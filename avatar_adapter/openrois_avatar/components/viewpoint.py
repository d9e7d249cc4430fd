"""Viewpoint: the camera position of the pictures. A component of OpenRoIS; the standard has none."""

from collections.abc import Callable

from openrois_body.body import Body

from openrois.adapter import BadParameter, Component, ComponentStatus, Unsupported, command, event, query

__all__ = ["Viewpoint"]


class Viewpoint(Component, authority="OpenRoIS", function="function"):
    """Chooses the game engine's camera for all viewers, which share its pictures; it needs no reservation.

    Args:
        body: the figure whose engine has the cameras.
        viewpoints: returns the names that the game engine offers now; it begins with the first.
        engine_status: returns the status of the game engine.
    """

    def __init__(
        self, body: Body, viewpoints: Callable[[], tuple[str, ...]], engine_status: Callable[[], ComponentStatus]
    ) -> None:
        super().__init__()
        self._body = body
        self._viewpoints = viewpoints
        self._engine_status = engine_status

    def condition(self) -> ComponentStatus:
        """Return the status of the game engine."""
        return self._engine_status()

    @query
    async def available_viewpoints(self) -> tuple[str, ...]:
        """Return the names that `choose` takes."""
        return self._viewpoints()

    @query
    async def viewpoint(self) -> str:
        """Return the name of the current viewpoint."""
        return self._current()

    @command
    async def choose(self, viewpoint: str) -> None:
        """Show the avatar from a viewpoint, to every viewer.

        Raises:
            Unsupported: the game engine offers no viewpoints at all.
            BadParameter: it does not offer this one.
        """
        offered = self._viewpoints()
        if not offered:
            raise Unsupported("the game engine offers no viewpoints; its HELLO has to name them")
        if viewpoint not in offered:
            raise BadParameter(f"there is no viewpoint {viewpoint!r}; available_viewpoints: {', '.join(offered)}")
        if viewpoint != self._current():
            self._body.show_from(viewpoint)
            self.viewpoint_changed(viewpoint)

    @event
    def viewpoint_changed(self, viewpoint: str) -> None:
        """The pictures show the avatar from another viewpoint."""

    def _current(self) -> str:
        offered, chosen = self._viewpoints(), self._body.viewpoint
        return chosen if chosen in offered else next(iter(offered), "")
