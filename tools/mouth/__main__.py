"""`python -m tools.mouth`: fit the weights of the mouth that is read from sound, and write their module.

The weights differ a little from run to run, as the breath of some of espeak's voices does.

It takes about two minutes and needs espeak (`openrois[speech]`) and flite. What came of it is judged by other
sentences: `tests/body/speech/test_mouth_agreement.py`, `python -m openrois_bench.spoken.mouth`.
"""

import sys
import textwrap
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray
from openrois_body.speech import mouth_weights

from tools.mouth.corpus import labelled, sentences
from tools.mouth.network import fit

__all__ = ["main"]

_UNIT: Final = 256
_HEAD: Final = f'''"""Weights of the network that reads a mouth from sound, written by `python -m tools.mouth`. Pure."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

__all__ = ["HIDDEN", "SHAPES"]


def _matrix(rows: int, numbers: str) -> NDArray[np.float32]:
    return np.array(numbers.split(), np.float32).reshape(rows, -1) / np.float32({_UNIT})


'''


def main() -> None:
    """Fit, and write."""
    chance = np.random.default_rng(1)
    features, labels = [], []
    for spoken, changes in sentences():
        for made, known in labelled(spoken, changes, chance):
            features.append(made)
            labels += known
    sys.stderr.write(f"{len(labels)} moments of sound\n")
    hidden, shapes = fit(np.concatenate(features), np.array(labels))
    Path(mouth_weights.__file__).write_text(_module(hidden, shapes), encoding="utf-8")


def _module(hidden: NDArray[np.float32], shapes: NDArray[np.float32]) -> str:
    tables = (
        _table("HIDDEN", hidden, "Rows: parts of the hidden layer. Columns: features, and what is added."),
        _table("SHAPES", shapes, "Rows: labels. Columns: parts of the hidden layer, and what is added."),
    )
    return _HEAD + "".join(tables)


def _table(name: str, weights: NDArray[np.float32], told: str) -> str:
    numbers = " ".join(str(round(float(each) * _UNIT)) for each in weights.ravel())
    lines = textwrap.fill(numbers, 118, initial_indent="    ", subsequent_indent="    ")
    return f'{name}: Final = _matrix(\n    {len(weights)},\n    """\n{lines}\n    """,\n)\n"""{told}"""\n'


if __name__ == "__main__":
    main()
