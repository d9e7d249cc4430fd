"""Short-lived credentials for TURN servers, made of a secret that these know. Pure: the time is an argument."""

import base64
import hashlib
import hmac


def turn_credential(secret: str, expires_at: int, user: str) -> tuple[str, str]:
    """A username and a credential that a TURN server which knows `secret` accepts until `expires_at`.

    This is the scheme `use-auth-secret` of coturn and others (draft-uberti-behave-turn-rest-00): the username is
    `<expires_at>:<user>`, in epoch seconds, and the credential its HMAC-SHA1 in base 64.
    """
    username = f"{expires_at}:{user}"
    digest = hmac.digest(secret.encode(), username.encode(), hashlib.sha1)
    return username, base64.b64encode(digest).decode()
