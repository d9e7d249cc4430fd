"""Viewpoint: from where the pictures show the avatar. A component of our own; the standard has none."""

from collections.abc import Callable

from openrois.adapter import BadParameter, Component, ComponentStatus, Unsupported, command, event, query
from openrois_avatar.body import Body

__all__ = ["Viewpoint"]


class Viewpoint(Component, authority="OpenRoIS", function="function"):
    """Chooses the game engine's camera, for all viewers together: they share its pictures. Of class function, as Gaze.

    Args:
        body: the figure whose engine has the cameras.
        viewpoints: the names that the game engine offers now; the first is the one that it begins with.
        engine_status: tells whether the game engine works now.
    """

    def __init__(
        self, body: Body, viewpoints: Callable[[], tuple[str, ...]], engine_status: Callable[[], ComponentStatus]
    ) -> None:
        super().__init__()
        self._body = body
        self._viewpoints = viewpoints
        self._engine_status = engine_status

    def condition(self) -> ComponentStatus:
        """Follow the game engine."""
        return self._engine_status()

    @query
    async def available_viewpoints(self) -> tuple[str, ...]:
        """Return the names that `choose` takes."""
        return self._viewpoints()

    @query
    async def viewpoint(self) -> str:
        """Return the name of the viewpoint that the pictures have now."""
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
            raise Unsupported("the game engine offers no viewpoints to choose from")
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
