"""The tree of errors."""

import inspect
import re

import pytest

from harness import errors

CLASSES = [item for _, item in inspect.getmembers(errors, inspect.isclass)]


def test_the_drawn_tree_is_the_tree():
    """The picture at the top of the module names every error under its root, and no other."""
    drawn = re.findall(r"[├└]── (\w+)", errors.__doc__)
    assert sorted(drawn) == sorted(item.__name__ for item in CLASSES if item is not errors.HarnessError)


def test_every_error_has_one_root(subtests):
    """Catching HarnessError catches each of them."""
    for error in CLASSES:
        with subtests.test(error=error):
            assert issubclass(error, errors.HarnessError)


def test_contract_violation_names_its_check():
    """The name of the check that failed can be read off the error and off its text."""
    violation = errors.ContractViolation("is_finite", "the distance is nan")
    assert (violation.check, str(violation)) == ("is_finite", "is_finite: the distance is nan")


@pytest.mark.parametrize(
    ("error", "line"),
    [
        (ValueError("two\n  lines"), "ValueError: two lines"),
        (KeyError("name"), "KeyError: 'name'"),
        (RuntimeError(), "RuntimeError"),
    ],
)
def test_an_exception_fits_on_one_line(error, line):
    """Type and message, line breaks and all other white space as one blank."""
    assert errors.one_line(error) == line


def test_a_sentence_keeps_the_capitals_of_a_path():
    """Only the first letter changes."""
    assert errors.sentence("experiment file 'A/b.toml'") == "Experiment file 'A/b.toml'"


def test_an_exception_of_a_stranger_is_shown_escaped_and_cut():
    """What it says may come from a file."""
    assert errors.one_line(ValueError("\x1b]0;title\x07")) == "ValueError: \\x1b]0;title\\x07"
    assert len(errors.one_line(ValueError("x" * 13_000))) == 300
