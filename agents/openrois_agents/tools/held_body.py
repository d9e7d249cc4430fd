"""The body that a caller holds for a task."""

from contextlib import AsyncExitStack

from openrois.client import Body, BodyInfo, Client, ComponentProxy, OutOfResources, Unsupported
from openrois.types.references import engine_of
from openrois_agents.tools.abilities import ABILITIES
from openrois_agents.tools.permits import Permits
from openrois_agents.tools.running import Runner
from openrois_agents.tools.settings import CALL

__all__ = ["HeldBody"]


class HeldBody:
    """Components of one body that are bound for a task, and what the task may do with them.

    Args:
        client: has bound them.
        body: what is bound.
        info: all that the body had when it was reserved.
        permits: what the task may do.
        runner: runs its commands.
        stack: gives it back.
    """

    def __init__(
        self,
        client: Client,
        body: Body,
        info: BodyInfo,
        permits: Permits,
        runner: Runner,
        stack: AsyncExitStack,
    ) -> None:
        self.client = client
        self.body = body
        self.info = info
        self.permits = permits
        self.runner = runner
        self._stack = stack
        self._bound: dict[str, ComponentProxy] = {}

    @property
    def engine_id(self) -> str:
        """The engine that the body is."""
        return self.body.engine_id

    @property
    def tools(self) -> list[str]:
        """The tools that the task may use, and the body has a component for."""
        has = (tool for tool, ability in ABILITIES.items() if self.body.get(ability.urn) is not None)
        return sorted(self.permits.tools & {*has, CALL})

    def require_held(self) -> None:
        """Do nothing while the body is held.

        Raises:
            OutOfResources: it was lost; the sentence says why.
        """
        if self.body.error is not None:
            raise OutOfResources(f"{self.engine_id} was lost: {self.body.error}; use_body reserves a body again")

    def acting(self, tool: str) -> ComponentProxy:
        """Return the component for a tool, and count a movement where it is one.

        Raises:
            Unsupported: the task may not use it, or the body has no such component.
            OutOfResources: the body is lost, or there were too many movements.
        """
        self.require_held()
        self.permits.require(tool)
        ability = ABILITIES[tool]
        component = self.body.get(ability.urn)
        if component is None:
            raise Unsupported(f"{self.engine_id} is held without what {tool} needs: it has {', '.join(self.tools)}")
        if ability.moves:
            self.permits.count_movement()
        return component

    async def bind(self, component_ref: str) -> ComponentProxy:
        """Bind another component of the body for the rest of the task.

        Raises:
            OutOfResources: another application has it.
            Unsupported: it is of another body.
        """
        if engine_of(component_ref) != self.engine_id:
            raise Unsupported(f"{component_ref} is no component of {self.engine_id}, which this task holds")
        if component_ref not in self._bound:
            component = self.client.component(component_ref)
            await self._stack.enter_async_context(component.bound())
            self._bound[component_ref] = component
        return self._bound[component_ref]

    async def give_back(self) -> None:
        """Stop what runs and release all components."""
        await self.runner.stop_all()
        await self._stack.aclose()
