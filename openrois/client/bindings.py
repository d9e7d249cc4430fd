"""The components that an application wants bound, over as many connections as that takes."""

import asyncio
from collections.abc import Callable
from dataclasses import dataclass
from weakref import WeakValueDictionary

from openrois.client.notices import BindingLent, BindingLost, BindingRestored, Notice
from openrois.client.rpc_call import ask
from openrois.errors import OutOfResources, RoISError
from openrois.jsonrpc.session import RpcError, RpcSession
from openrois.types.messages import ComponentParams, ReturnResult

__all__ = ["Bindings"]


@dataclass
class _Binding:
    """One component.

    Attributes:
        held: whether the gateway has it bound, as far as is known.
        missed: whether the application was notified that it is not.
        lent: whether another application has it for a time, and it comes back by itself.
        uses: how many blocks and calls of `bind` want it.
    """

    held: bool = True
    missed: bool = False
    lent: bool = False
    uses: int = 0


class Bindings:
    """Components that are bound, and are to be bound again on the next connection.

    Args:
        tell: takes what the application should know.
    """

    def __init__(self, tell: Callable[[Notice], None]) -> None:
        self._tell = tell
        self._wanted: dict[str, _Binding] = {}
        self._turns: WeakValueDictionary[str, asyncio.Lock] = WeakValueDictionary()

    @property
    def incomplete(self) -> bool:
        """Whether a wanted component is not bound, and does not come back by itself."""
        return not all(binding.held or binding.lent for binding in self._wanted.values())

    def turn(self, component_ref: str) -> asyncio.Lock:
        """Return the lock of a component for bind and release: a release must not overtake the bind of another task."""
        return self._turns.setdefault(component_ref, asyncio.Lock())

    def wants(self, component_ref: str) -> bool:
        """Tell whether a component is wanted."""
        return component_ref in self._wanted

    def use(self, component_ref: str) -> None:
        """Note that a component was bound once more."""
        binding = self._wanted.setdefault(component_ref, _Binding())
        binding.held, binding.missed, binding.lent = True, False, False
        binding.uses += 1

    def gave_back(self, component_ref: str) -> None:
        """Note that a component is not wanted any more."""
        self._wanted.pop(component_ref, None)

    def taken(self, component_ref: str, reason: str) -> None:
        """Note that another application has a component now: it is not bound again."""
        binding = self._wanted.get(component_ref)
        if binding is not None and (binding.held or binding.lent):
            del self._wanted[component_ref]
            self._tell(BindingLost(component_ref, OutOfResources(f"another application holds it now: {reason}")))

    def lent(self, component_ref: str, holder: str, seconds: float) -> None:
        """Note that another application has a component for a time, after which it comes back."""
        binding = self._wanted.get(component_ref)
        if binding is not None and binding.held:
            binding.held, binding.missed, binding.lent = False, True, True
            self._tell(BindingLent(component_ref, holder, seconds))

    def returned(self, component_ref: str) -> None:
        """Note that a component has come back."""
        binding = self._wanted.get(component_ref)
        if binding is not None and binding.lent:
            binding.held, binding.missed, binding.lent = True, False, False
            self._tell(BindingRestored(component_ref))

    def not_returned(self, component_ref: str) -> None:
        """Note that a component is free that was lent: it is bound again as what was lost is."""
        binding = self._wanted.get(component_ref)
        if binding is not None:
            binding.lent = False

    def unuse(self, component_ref: str) -> bool:
        """Note that one user of the component needs it no more; tell whether that was the last."""
        binding = self._wanted.get(component_ref)
        if binding is None:
            return False
        binding.uses -= 1
        return binding.uses <= 0

    def lost(self) -> None:
        """Note that the connection has ended, and with it every binding."""
        for binding in self._wanted.values():
            binding.held = binding.lent = False

    async def renew(self, session: RpcSession, timeout: float) -> None:
        """Bind everything again; binding what is bound already changes nothing.

        Raises:
            ConnectionLost: the connection ended.
        """
        wanted = tuple((ref, binding) for ref, binding in self._wanted.items() if not binding.lent)
        await asyncio.gather(*(self._renew(session, timeout, ref, binding) for ref, binding in wanted))

    async def _renew(self, session: RpcSession, timeout: float, component_ref: str, binding: _Binding) -> None:
        params = ComponentParams(component_ref=component_ref)
        try:
            await ask(session, "rois.command.bind", params, ReturnResult, timeout=timeout)
        except (RoISError, RpcError, TimeoutError) as error:
            self._missing(component_ref, binding, error)
        else:
            self._restored(session, component_ref, binding)

    def _missing(self, component_ref: str, binding: _Binding, error: Exception) -> None:
        binding.held = False
        if not binding.missed:
            binding.missed = True
            self._tell(BindingLost(component_ref, error))

    def _restored(self, session: RpcSession, component_ref: str, binding: _Binding) -> None:
        if self._wanted.get(component_ref) is not binding:
            # It was given back meanwhile, and the gateway may have processed that first.
            session.post("rois.command.release", {"component_ref": component_ref})
        elif not binding.held:
            binding.held, binding.missed = True, False
            self._tell(BindingRestored(component_ref))
