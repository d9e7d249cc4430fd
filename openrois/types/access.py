"""Params and results of the extension about tokens: `openrois.auth.*`."""

from typing import Annotated, ClassVar, Final

from pydantic import Field

from openrois.types.messages import ReturnResult
from openrois.types.model import Model

__all__ = ["MAX_TOKEN", "AuthExpiringNotification", "AuthRefreshParams", "AuthRefreshResult"]

MAX_TOKEN: Final = 6144
"""Characters of a token."""


class AuthRefreshParams(Model):
    """Params of `openrois.auth.refresh`: a token of the same subject, from now on in place of the present one."""

    token: Annotated[str, Field(min_length=1, max_length=MAX_TOKEN, repr=False)]


class AuthRefreshResult(ReturnResult):
    """Result of `openrois.auth.refresh`: for how many seconds the connection may now go on."""

    seconds: Annotated[int, Field(ge=0)] = 0


class AuthExpiringNotification(Model):
    """Params of the notification `openrois.auth.expiring`: in how many seconds the connection will be closed."""

    method: ClassVar[str] = "openrois.auth.expiring"

    seconds: Annotated[int, Field(ge=0)]
