"""The extension `openrois.auth`: a new token on a connection that goes on."""

from typing import Final

from openrois_conformance.deviation import Deviation
from openrois_conformance.stage import Checks, Needs, Stage

__all__ = ["CHECKS"]

CHECKS: Final = Checks()

REFRESH: Final = "openrois.auth.refresh"


@CHECKS("token-refresh", Needs.EXTENSIONS)
async def _token_refresh(stage: Stage) -> None:
    """An invalid token is refused and changes nothing; a valid one is accepted, where the gateway asks for any."""
    app = await stage.application()
    await app.granted("openrois.hello", version="1")
    await app.error(REFRESH, -32602)
    refused = await app.refused(REFRESH, "BAD_PARAMETER", "UNSUPPORTED", token="conformance.is.none")  # noqa: S106
    token = stage.setting.applications.credentials.newest()
    if refused["return_code"] == "BAD_PARAMETER":
        if token is None:
            raise Deviation("a gateway that asks for tokens to let no client in without", "this connection")
        stage.setting.transcript.hide(token)
        await app.granted(REFRESH, token=token)
    await app.granted("rois.system.connect")
