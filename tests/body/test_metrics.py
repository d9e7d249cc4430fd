from openrois_body.metrics import body_figures
from openrois_body.sensing.figures import SenseFigures
from openrois_body.speech.speech_control import SpeechFigures, SpeechOutcomes
from openrois_body.teleoperation.operator_control import OperatorControl

from tests.support.streaming import VirtualClock


def test_figures_are_a_copy() -> None:
    vision, operator_control = SenseFigures(analysed=3), OperatorControl("avatar/teleoperation", VirtualClock())
    operator_control.figures.taken = 7
    speech = SpeechFigures(refused=2)
    speeches = SpeechOutcomes(begun=1)
    senses, outcomes, spoken, begun = body_figures({"vision": vision}, operator_control.figures, speech, speeches)
    speech.refused = 3
    speeches.begun = 2
    vision.analysed = 4
    assert senses.samples == ((("vision",), SenseFigures(analysed=3)),)
    assert outcomes.samples == ((("taken",), 7), (("refused",), 0), (("malformed",), 0), (("dropped",), 0))
    assert begun.samples == ((("begun",), 1), (("starved",), 0), (("finished",), 0), (("cut",), 0))
    assert spoken.samples == ((("taken",), 0), (("dropped",), 0), (("refused",), 2), (("malformed",), 0))
