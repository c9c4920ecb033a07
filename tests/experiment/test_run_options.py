"""What editors and type checkers know of `harness.run` is what it takes."""

from dataclasses import fields
from typing import get_type_hints

from harness.experiment.plan import Experiment
from harness.experiment.run_options import RunArguments, RunOptions


def test_arguments_are_all_fields_in_their_order():
    """Of the experiment, then of the options; a new field may not be forgotten."""
    assert list(RunArguments.__annotations__) == [field.name for field in (*fields(Experiment), *fields(RunOptions))]


def test_only_algorithms_have_to_be_given():
    """An environment takes no simulator; with an arm the experiment asks for one."""
    assert RunArguments.__required_keys__ == {"algo"}


def test_options_have_their_types():
    """The options are taken as they are; lists of the experiment may be single names."""
    told, options = get_type_hints(RunArguments), get_type_hints(RunOptions)
    assert {name: told[name] for name in options} == options
