"""What a gateway asserts to another one about the application whose session it opens there. Pure."""

from collections.abc import Mapping
from typing import Annotated, Any, Final, Literal, Self

from pydantic import Field, ValidationError

from openrois.auth.principal import LOCAL, Principal, Role
from openrois.errors import BadParameter
from openrois.types.model import Model

__all__ = ["MAX_SCOPE", "Assertion"]

MAX_SCOPE: Final = 512
"""Patterns in the scope of an application that is asserted."""


class Assertion(Model):
    """A principal, as the gateway that has verified its token asserts it, and the line of sessions it belongs to.

    Attributes:
        kind: `local` where that gateway asks for no tokens.
        subject: of the principal.
        roles: of the principal.
        scope: of the principal.
        expires: epoch seconds at which its token ends; None for never. The gateway that asserts it ends the session
            then, by its own clock; one of an earlier version that is asked judges that itself.
        token_id: the id of its token, so that a revocation reaches this session too.
        rank: of the principal; empty, of a gateway of an earlier version, counts as the lowest.
        address: where the application comes from.
        client_id: the id that adapters know the application by; empty where it needs none.
        line: names the session over all its connections; empty where it cannot be resumed.
        generation: how often the line was resumed.
    """

    kind: Literal["local", "token"]
    subject: Annotated[str, Field(max_length=1024)]
    roles: Annotated[tuple[Annotated[Role, Field(strict=False)], ...], Field(max_length=16, strict=False)] = ()
    scope: Annotated[tuple[str, ...], Field(max_length=MAX_SCOPE, strict=False)] = ()
    expires: float | None = None
    token_id: Annotated[str, Field(max_length=1024)] = ""
    rank: Annotated[str, Field(max_length=64)] = ""
    address: Annotated[str, Field(max_length=256)] = ""
    client_id: Annotated[str, Field(max_length=64)] = ""
    line: Annotated[str, Field(max_length=64)] = ""
    generation: Annotated[int, Field(ge=0)] = 0

    @classmethod
    def of(cls, principal: Principal, **more: Any) -> Self:
        """Return what is asserted of a principal, and of its session.

        Raises:
            BadParameter: its scope is too long for that.
        """
        if len(principal.scope) > MAX_SCOPE:
            raise BadParameter(f"a scope of {len(principal.scope)} patterns goes to no other gateway: {MAX_SCOPE} do")
        return cls(
            kind="local" if principal is LOCAL else "token",
            subject=principal.subject,
            roles=tuple(sorted(principal.roles)),
            scope=principal.scope,
            expires=principal.expires,
            token_id=principal.token_id,
            rank=principal.rank,
            **more,
        )

    @classmethod
    def parse(cls, said: Mapping[str, Any]) -> Self:
        """Return what another gateway asserts.

        Raises:
            BadParameter: it is no assertion.
        """
        try:
            return cls.read_newer(said)
        except ValidationError as error:
            first = error.errors(include_url=False, include_context=False, include_input=False)[0]
            path = ".".join(str(step) for step in first["loc"])
            raise BadParameter(f"what the gateway asserts is no principal: {path}: {first['msg']}"[:300]) from None

    @property
    def principal(self) -> Principal:
        """The principal that is asserted; that its token ends is no matter of the gateway that is told."""
        if self.kind == "local":
            return LOCAL
        return Principal(self.subject, frozenset(self.roles), self.scope, None, self.token_id, self.rank)

    def hello(self) -> dict[str, Any]:
        """Return it as an object for JSON."""
        return self.model_dump(mode="json")
