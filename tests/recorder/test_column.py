"""What a reward may return, and what is kept of its code."""

import functools
import hashlib
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from harness.recorder.column import as_number, source_of
from harness.reward.given import opened


def scaled(factor, observation, action, next_observation, info):
    """A reward with a parameter."""
    return factor * float(next_observation[0])


@dataclass
class Scaled:
    """The same as an object."""

    factor: float
    seen: Any = None

    def __call__(self, observation, action, next_observation, info):
        """Scale."""
        return self.factor * float(next_observation[0])


def test_one_number_is_a_number(subtests):
    """Of whatever type."""
    for value in [2, 2.0, np.float32(2), np.array(2), np.int64(2), np.full((), 2.0)]:
        with subtests.test(value=value):
            assert as_number(value) == 2.0
            assert type(as_number(value)) is float


def test_truth_is_a_number():
    """1 or 0."""
    assert (as_number(True), as_number(np.False_)) == (1.0, 0.0)


def test_what_is_no_finite_number_is_refused(subtests):
    """A list of one number too: it may be that of a batch."""
    rows = [
        *((np.ones(1), ValueError), ([1.0], ValueError), (float("nan"), ValueError), (np.float32("-inf"), ValueError)),
        *((None, TypeError), ("1", TypeError), (1j, TypeError), ({}, TypeError)),
    ]
    for value, kind in rows:
        with subtests.test(value=value, kind=kind), pytest.raises(kind):
            as_number(value)


def test_code_of_a_function_is_kept():
    """With its SHA-256."""
    source = source_of(scaled)
    assert source.text.startswith("def scaled(factor")
    assert source.sha256 == hashlib.sha256(source.text.encode()).hexdigest()


def test_parameters_are_kept_with_the_code():
    """Of a partial function and of a dataclass: another parameter is another reward."""
    for one, other in ((functools.partial(scaled, 2.0), functools.partial(scaled, 3.0)), (Scaled(2.0), Scaled(3.0))):
        assert source_of(one).sha256 != source_of(other).sha256
        assert "2.0" in source_of(one).text


def test_parameters_that_are_objects_tell_no_address():
    """The same reward has the same code in every process."""
    assert "tests.recorder.test_column.Scaled" in source_of(Scaled(2.0, seen=Scaled(1.0))).text
    assert "0x" not in source_of(Scaled(2.0, seen=object())).text


def test_code_that_python_cannot_tell_is_empty():
    """As of a built-in, or of what was typed into a shell."""
    assert source_of(max).text == source_of(eval("lambda o, a, n, i: 0.0")).text == ""


def test_code_of_terms_by_name_is_that_of_each():
    """Beside its name."""
    terms = opened({"left": "left", "scaled": functools.partial(scaled, 2.0)}, "reward 'it'")
    assert source_of(terms).text.startswith("# left\ninfo key 'left'\n# scaled\ndef scaled(")
