"""Figures of a language model at a server: what it was asked, what it used, how often it failed. Pure."""

from dataclasses import dataclass
from typing import Final

from openrois.metrics.figure import Figure

__all__ = ["MODEL_FIGURES", "ModelFigures"]


@dataclass(slots=True)
class ModelFigures:
    """What a model did since the process began.

    Attributes:
        requests: to the server.
        failures: requests without a whole answer, as the server did not give it.
        interruptions: answers that were broken off, as the visitor spoke, or the body was lost or stopped.
        tool_calls: that it made.
        refused_calls: of these, calls that were mistakes, or too many.
        read, written: tokens, as the server says, or estimated.
        seconds: from requests to the ends of their answers.
    """

    requests: int = 0
    failures: int = 0
    interruptions: int = 0
    tool_calls: int = 0
    refused_calls: int = 0
    read: int = 0
    written: int = 0
    seconds: float = 0.0


MODEL_FIGURES: Final[tuple[Figure[ModelFigures], ...]] = (
    Figure(
        "openrois_mind_model_requests_total",
        "counter",
        "Requests to the server of the language model.",
        lambda figures: figures.requests,
    ),
    Figure(
        "openrois_mind_model_failures_total",
        "counter",
        "Requests without a whole answer, as the server did not give it.",
        lambda figures: figures.failures,
    ),
    Figure(
        "openrois_mind_model_interruptions_total",
        "counter",
        "Answers that were broken off, as the visitor spoke, or the body was lost or stopped.",
        lambda figures: figures.interruptions,
    ),
    Figure(
        "openrois_mind_model_tool_calls_total",
        "counter",
        "Calls of tools that the language model made.",
        lambda figures: figures.tool_calls,
    ),
    Figure(
        "openrois_mind_model_refused_calls_total",
        "counter",
        "Calls of tools that were mistakes, or too many.",
        lambda figures: figures.refused_calls,
    ),
    Figure(
        "openrois_mind_model_read_tokens_total",
        "counter",
        "Tokens that the language model has read, as its server says, or estimated.",
        lambda figures: figures.read,
    ),
    Figure(
        "openrois_mind_model_written_tokens_total",
        "counter",
        "Tokens that the language model has written, as its server says, or estimated.",
        lambda figures: figures.written,
    ),
    Figure(
        "openrois_mind_model_seconds_total",
        "counter",
        "Seconds from requests to the ends of their answers.",
        lambda figures: figures.seconds,
    ),
)
"""What of it is served."""
