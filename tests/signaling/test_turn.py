import base64
import hashlib
import hmac

from openrois_signaling.turn import turn_credential


def test_a_credential_is_the_signature_of_its_username() -> None:
    username, credential = turn_credential("secret", 1_700_000_000, "alice")
    assert username == "1700000000:alice"
    assert base64.b64decode(credential) == hmac.new(b"secret", username.encode(), hashlib.sha1).digest()
