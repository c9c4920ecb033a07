"""Dataclasses as plain data: what comes back is what was told."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import pytest

from harness.files.plain import Plain


@dataclass(frozen=True)
class Part(Plain):
    """A dataclass in another."""

    name: str
    numbers: tuple[float, ...] = ()


@dataclass(frozen=True)
class Other(Plain):
    """One that may stand in its place."""

    target: str


@dataclass(frozen=True)
class Whole(Plain):
    """Every kind of field."""

    part: Part
    parts: tuple[Part | Other, ...] = ()
    pairs: tuple[tuple[str, int], ...] = ()
    place: Path = Path()
    seen: frozenset[int] = frozenset()
    count: int | None = None
    perhaps: tuple[tuple[int, ...], ...] | None = None
    noun: ClassVar[str] = "whole"


WHOLE = Whole(
    Part("a", (1.0, 2.5)), (Other("b"), Part("c")), (("d", 1),), Path("e/f"), frozenset({3, 1}), 4, ((1,), ())
)


@pytest.mark.parametrize("whole", [WHOLE, Whole(Part("a"))])
def test_what_was_told_comes_back(whole):
    """Through JSON too."""
    assert Whole.from_json(whole.to_json()) == whole
    assert Whole.from_json(json.loads(json.dumps(whole.to_json()))) == whole


def test_fields_stand_in_their_order():
    """Sets are sorted, tuples are lists, paths are text; what belongs to the class does not stand there."""
    told = WHOLE.to_json()
    assert list(told) == ["part", "parts", "pairs", "place", "seen", "count", "perhaps"]
    assert told["part"] == {"name": "a", "numbers": [1.0, 2.5]}
    assert (told["pairs"], told["place"], told["seen"]) == ([["d", 1]], "e/f", [1, 3])


def test_keys_that_are_missing_have_their_default():
    """Those that no field has are left out: a later version may have written them."""
    assert Whole.from_json({"part": {"name": "a"}, "later": 1}) == Whole(Part("a"))
