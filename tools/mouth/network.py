"""The fit of a network with one hidden layer, by Adam on random parts of what is known; the same with the same seed."""

from typing import Final

import numpy as np
from numpy.typing import NDArray
from openrois_body.speech.mouth import LABELS, opening

__all__ = ["fit"]

HIDDEN: Final = 24
STEPS: Final = 3_000
_PART: Final = 4_000
_RATE: Final = 0.01
_DECAY: Final = 1e-4
_KEPT, _KEPT_SQUARES = 0.9, 0.99

Matrix = NDArray[np.float32]
_GROUPS: Final = np.eye(3, dtype=np.float32)[[opening(*label) for label in LABELS]]
"""Which opening (columns) each label (rows) is of."""


def fit(features: Matrix, labels: NDArray[np.int64], seed: int = 0) -> tuple[Matrix, Matrix]:
    """Return the weights of the hidden layer and of the labels; the last column of each is added.

    Half of what is minimised is that the label is wrong, the other half that its opening is.
    """
    chance = np.random.default_rng(seed)
    mean, deviation = features.mean(0), features.std(0) + np.float32(1e-3)
    size = features.shape[1]
    weights = [
        chance.normal(0, size**-0.5, (size, HIDDEN)).astype(np.float32),
        np.zeros(HIDDEN, np.float32),
        chance.normal(0, HIDDEN**-0.5, (HIDDEN, len(LABELS))).astype(np.float32),
        np.zeros(len(LABELS), np.float32),
    ]
    moments, squares = [0 * each for each in weights], [0 * each for each in weights]
    for step in range(STEPS):
        part = chance.integers(0, len(features), _PART)
        slopes = _slopes(weights, (features[part] - mean) / deviation, labels[part])
        rate = _RATE * min(1.0, 2 * (1 - step / STEPS))
        for number, slope in enumerate(slopes):
            moments[number] = _KEPT * moments[number] + (1 - _KEPT) * slope
            squares[number] = _KEPT_SQUARES * squares[number] + (1 - _KEPT_SQUARES) * slope**2
            middle = moments[number] / (1 - _KEPT ** (step + 1))
            spread = np.sqrt(squares[number] / (1 - _KEPT_SQUARES ** (step + 1)))
            weights[number] = weights[number] - rate * middle / (spread + 1e-8)
    first, first_bias, second, second_bias = weights
    # Features are neither shifted nor scaled when they are used: the weights are.
    scaled = first.T / deviation
    hidden = np.column_stack([scaled, first_bias - scaled @ mean])
    return hidden.astype(np.float32), np.column_stack([second.T, second_bias]).astype(np.float32)


def _slopes(weights: list[Matrix], features: Matrix, labels: NDArray[np.int64]) -> list[Matrix]:
    first, first_bias, second, second_bias = weights
    hidden = np.tanh(features @ first + first_bias)
    scores = hidden @ second + second_bias
    likely = np.exp(scores - scores.max(1, keepdims=True))
    likely /= likely.sum(1, keepdims=True)
    right = np.eye(len(LABELS), dtype=np.float32)[labels]
    within = likely * (_GROUPS[labels] @ _GROUPS.T)
    within /= within.sum(1, keepdims=True) + 1e-9
    wrong = (likely - (right + within) / 2) / len(labels)
    back = wrong @ second.T * (1 - hidden**2)
    return [
        features.T @ back + _DECAY * first,
        back.sum(0),
        hidden.T @ wrong + _DECAY * second,
        wrong.sum(0),
    ]
