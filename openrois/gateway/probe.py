"""Asks a gateway of this machine whether it is alive: for health checks that run a program in its container."""

import http.client
import ssl
import sys
import urllib.request
from collections.abc import Sequence
from typing import Final

__all__ = ["DEFAULT", "main"]

DEFAULT: Final = "https://127.0.0.1:8765/healthz"
"""Address of a gateway that is configured as `packaging/gateway.toml` has it."""

_TIMEOUT: Final = 4.0


def main(arguments: Sequence[str]) -> int:
    """Return 0 if the gateway answers with 200, else 1 and say why.

    Args:
        arguments: at most one, the address that is asked; `https://127.0.0.1:8765/healthz` without it.
    """
    url = arguments[0] if arguments else DEFAULT
    context = ssl.create_default_context()
    # The certificate is for the gateway's public name; the probe sends no secret.
    context.check_hostname = False
    context.verify_mode = ssl.CERT_NONE
    opener = urllib.request.build_opener(urllib.request.ProxyHandler({}), urllib.request.HTTPSHandler(context=context))
    try:
        with opener.open(url, timeout=_TIMEOUT):
            return 0
    except (OSError, ValueError, http.client.HTTPException) as error:
        print(f"{url}: {error}", file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
