"""Results and notifications of a newer program: what this version does not know of them is passed over."""

from collections.abc import Iterator
from typing import Any

import pytest
from pydantic import ValidationError

from openrois.client.rpc_call import read_message
from openrois.types.messages import ExecuteParams, ProfileResult, ReturnResult
from openrois.types.methods import METHODS, NOTIFICATIONS
from openrois.types.model import Model
from tests.support.corpus import corpus
from tests.support.newer import with_more


def told() -> Iterator[Any]:
    """Return the models of all results and notifications, with their names in the corpus."""
    models = [*(each.result for each in METHODS), *(each.params for each in NOTIFICATIONS)]
    for model in dict.fromkeys(models):
        if issubclass(model, Model) and model.__name__ in corpus():
            yield pytest.param(model, id=model.__name__)


@pytest.mark.parametrize("model", list(told()))
def test_what_is_said_besides_is_passed_over_at_every_depth(model: type[Model]) -> None:
    read = model.read if issubclass(model, ReturnResult) else model.read_newer
    for case in corpus()[model.__name__]:
        if case.is_valid:
            assert read(with_more(case.message)) == model.model_validate(case.message), case.name
            assert read_message(model, with_more(case.message)) == model.model_validate(case.message), case.name


def test_a_request_is_done_as_it_is_said_or_refused() -> None:
    unit = {"component_ref": "robot/arm", "command_type": "start", "command_id": "c"}
    ExecuteParams.model_validate({"command_unit_list": [unit]})
    with pytest.raises(ValidationError, match="not_before"):
        ExecuteParams.model_validate({"command_unit_list": [{**unit, "not_before": 1}]})


def test_what_is_no_profile_is_none_of_a_newer_program_either() -> None:
    with pytest.raises(ValidationError, match="component_profiles"):
        ProfileResult.read({"return_code": "OK", "component_profiles": {"robot/arm": {"colour": "red"}}})
