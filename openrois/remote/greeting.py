"""The answer to our `openrois.hello`."""

from pydantic import ConfigDict

from openrois.types.streams import HelloResult

__all__ = ["Greeting"]


class Greeting(HelloResult):
    """The answer of a remote engine; members of newer engines are ignored."""

    model_config = ConfigDict(extra="ignore")
