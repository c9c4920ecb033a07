"""What a function is given: copies that it reads as it always did, and cannot write into."""

import copy
import json
import pickle
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import pytest

from harness.recorder.sealed import Sealer

INFO = {"a": {"b": 1.0, "c": [1, 2]}, "x": np.arange(3.0), "named": ("u", {"k": np.ones(2)}), "o": np.array([{"p": 1}])}


class Pair(NamedTuple):
    """An observation with names."""

    left: Any
    right: Any


WRITES = {
    "item": lambda info: info.__setitem__("a", 0),
    "pop": lambda info: info.pop("x"),
    "update": lambda info: info.update(y=1),
    "or": lambda info: info.__ior__({"y": 1}),
    "inner item": lambda info: info["a"].__setitem__("b", 0),
    "inner list": lambda info: info["a"]["c"].append(3),
    "array": lambda info: info["x"].__setitem__(0, 9),
    "array in place": lambda info: np.multiply(info["x"], 2, out=info["x"]),
    "array made writable": lambda info: info["x"].setflags(write=True),
    "array of objects made writable": lambda info: info["o"].setflags(write=True),
    "array in a tuple": lambda info: info["named"][1]["k"].fill(0),
    "array of objects": lambda info: info["o"][0].update(p=2),
}


def test_nothing_can_be_written_into(subtests):
    """At any depth; what was given stays as it was, and can be written into by its owner."""
    for case, write in WRITES.items():
        with subtests.test(case):
            info, sealer = copy.deepcopy(INFO), Sealer()
            with pytest.raises((TypeError, ValueError)):
                write(sealer.seal(info))
            assert json.dumps(info, default=str) == json.dumps(INFO, default=str)
            info["x"][0] = 5
            assert not sealer.is_open


def test_it_reads_as_a_dict():
    """By key, `get`, `in`, `|`, unpacking, `dict`, JSON and copies; those can be written into."""
    sealed = Sealer().seal({"a": {"b": 1.0}, "c": 2})
    assert (sealed["a"]["b"], sealed.get("d", 3), "c" in sealed, [*sealed]) == (1.0, 3, True, ["a", "c"])
    assert isinstance(sealed, dict)
    assert isinstance(sealed["a"], Mapping)
    for plain in (sealed | {"d": 4}, {**sealed, "d": 4}, dict(sealed, d=4)):
        assert plain == {"a": {"b": 1.0}, "c": 2, "d": 4}
    assert json.dumps(sealed) == '{"a": {"b": 1.0}, "c": 2}'
    for again in (copy.deepcopy(sealed), pickle.loads(pickle.dumps(sealed)), copy.copy(sealed), sealed.copy()):
        again["c"] = 5
    assert sealed["c"] == 2


def test_owner_s_later_writing_is_not_seen():
    """Envs and learners use their arrays again: what a function keeps of a step stays that step."""
    action = np.ones(2)
    sealed = Sealer().seal(action)
    action[:] = 9
    assert sealed.tolist() == [1, 1]


def test_named_tuples_keep_their_names():
    """Of observations."""
    sealed = Sealer().seal(Pair(np.ones(1), {"a": 1}))
    assert (sealed.left[0], sealed.right["a"]) == (1, 1)


def test_what_cannot_be_sealed_is_copied_for_each_function():
    """An object: one function writes into a copy of its own."""

    class Odd:
        def __init__(self) -> None:
            self.values = [1]

    sealer, odd = Sealer(), Odd()
    step = (sealer.seal({"odd": odd}),)
    assert sealer.is_open
    sealer.own(step)[0]["odd"].values.append(2)
    assert (odd.values, sealer.own(step)[0]["odd"].values) == ([1], [1])
