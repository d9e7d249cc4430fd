"""A component that needs ends of the robot's graph: its status and the reason of it follow from them."""

from collections.abc import Sequence

from openrois.adapter import ComponentStatus
from openrois_robots.adapter.link import RobotLink
from openrois_robots.ros2.graph.backend import Matched

__all__ = ["Bound", "Ends"]


class Ends:
    """The ends that a component needs, and the link to their robot.

    Args:
        link: to the robot.
        ends: each has to be matched.
    """

    def __init__(self, link: RobotLink, ends: Sequence[Matched]) -> None:
        self.link = link
        self._ends = tuple(ends)
        self._were_matched = False

    @property
    def status(self) -> ComponentStatus:
        """READY; UNINITIALIZED until the robot is linked and all are matched; ERROR when that is over."""
        if not self.link.is_up:
            return self.link.status
        if all(each.is_matched for each in self._ends):
            self._were_matched = True
            return ComponentStatus.READY
        return ComponentStatus.ERROR if self._were_matched else ComponentStatus.UNINITIALIZED

    @property
    def problem(self) -> str:
        """Why the status is not READY."""
        return self.link.problem or next(filter(None, (each.problem for each in self._ends)), "")


class Bound:
    """Mixin of a component that needs ends; it stands before others, and `ends` is set by the component."""

    ends: Ends

    def condition(self) -> ComponentStatus:
        """Return the status of the ends."""
        return self.ends.status

    def problem(self) -> str:
        """Return why they are not usable."""
        return self.ends.problem
