"""SystemInformation: where the avatar stands, and whether its engine works (component 1 of the standard)."""

import time
from collections.abc import Callable
from typing import Final

from openrois.component import Component, parameter_profile, query
from openrois.types.codes import ComponentFunction, ComponentStatus
from openrois.types.messages import Result
from openrois.types.profiles import QueryMessageProfile
from openrois.types.values import date_time, encode_list
from openrois_avatar.components.profiles import component_profile

__all__ = ["SystemInformation"]

_ORIGIN: Final = "0.0,0.0,0.0"


class SystemInformation(Component):
    """Answers from the game engine's connection; has no RoIS_Common, like the standard's profile.

    Args:
        avatar_ref: the id by which the avatar is known, the only entry of `robot_ref`.
        engine_status: tells whether the game engine works now.
        wall_clock: epoch seconds.
    """

    def __init__(
        self,
        avatar_ref: str,
        engine_status: Callable[[], ComponentStatus],
        wall_clock: Callable[[], float] = time.time,
    ) -> None:
        super().__init__(
            component_profile(
                "SystemInformation",
                ComponentFunction.SENSING,
                common=False,
                queries=(
                    QueryMessageProfile(
                        name="robot_position",
                        results=(
                            parameter_profile("timestamp", "DateTime"),
                            parameter_profile("robot_ref", "RoISIdentifier[]"),
                            parameter_profile("position_data", "String[]"),
                        ),
                    ),
                    QueryMessageProfile(
                        name="engine_status",
                        results=(
                            parameter_profile("status", "Component_Status"),
                            parameter_profile("operable_time", "DateTime"),
                        ),
                    ),
                ),
            )
        )
        self._avatar_ref = avatar_ref
        self._engine_status = engine_status
        self._wall_clock = wall_clock
        self._operable_since = date_time(wall_clock())

    @query("robot_position")
    async def robot_position(self) -> tuple[Result, ...]:
        """Return the moment, the avatar and its place `x,y,th`: it stands at the origin of its scene."""
        return (
            Result(name="timestamp", data_type_ref="DateTime", value=date_time(self._wall_clock())),
            Result(name="robot_ref", data_type_ref="RoISIdentifier[]", value=encode_list([self._avatar_ref])),
            Result(name="position_data", data_type_ref="String[]", value=encode_list([_ORIGIN])),
        )

    @query("engine_status")
    async def engine_status(self) -> tuple[Result, ...]:
        """Return whether the game engine works, and since when the adapter has been operable."""
        return (
            Result(name="status", data_type_ref="Component_Status", value=self._engine_status().value),
            Result(name="operable_time", data_type_ref="DateTime", value=self._operable_since),
        )
