"""Whatever is changed in a certificate, its replay tells it, or names the field as not played again."""

import json
from contextlib import closing
from dataclasses import replace
from functools import cache

import pytest

from harness import load_registry
from harness.errors import HarnessError
from harness.files.bounded import seal
from harness.registry import choose, read_given
from harness_plugins.audit import replay_file
from harness_plugins.audit.search import find
from harness_plugins.audit.search.out import certificates_of
from harness_plugins.audit.search.place import places_on_task, world_at
from harness_plugins.audit.search.replay import replay
from tests.plugins.audit.search.certified import film_of
from tests.plugins.audit.search.test_out import DOCKING, in_environment

PENDULUM, ACTS = "gymnasium:id=Pendulum-v1", {"kind": "random", "seed": 5}


@cache
def registry():
    """All that is installed, and a task that is given by hand."""
    return load_registry(given=read_given([DOCKING]))


PLACES = {
    "arm": lambda: places_on_task(
        registry(), [choose(registry(), "rewards", "arp")], "fd100-reach", None, "kinematic", 0.95
    )[0],
    "environment": lambda: in_environment(PENDULUM, "own", registry()),
    "chance": lambda: in_environment(PENDULUM, "own", registry()),
}


@cache
def whole(kind):
    """The text of a fresh certificate that holds all that one in such a place may hold."""
    place = PLACES[kind]()
    findings = find.cheats_at([place], registry(), find.Search(budget=2_000, starts=1))
    (made, *_), _ = certificates_of(findings, [place], registry(), seed=3, budget=100)
    if kind == "chance":
        rating = {"starts": [1_000_000, 1_000_001], "paid": [0.0, 0.0], "success": [0, 0]}
        with closing(world_at(place, registry())) as world:
            made = replay(replace(made, policy=ACTS, rating=rating), world).found
    if kind != "arm":
        made = replace(made, film=film_of((0, 5, 10)))
    return json.dumps(made.to_json())


@pytest.fixture(autouse=True)
def _no_films(monkeypatch):
    monkeypatch.setattr("harness_plugins.audit.search.out.films_of", lambda *given: [None] * len(given[-1]))


def _leaves(data, *path):
    """The path of each value; of a list of values the one in its middle."""
    if isinstance(data, dict):
        return [it for key, value in data.items() for it in _leaves(value, *path, key)]
    if isinstance(data, list) and data:
        every = range(len(data)) if isinstance(data[0], dict) else [len(data) // 2]
        return [it for k in every for it in _leaves(data[k], *path, k)]
    return [] if data == [] else [path]


def _other(value):
    if value is None:
        return 0.5
    if value in (0, 1):
        return type(value)(1 - value)
    return f"{value}x" if isinstance(value, str) else value + type(value)(1)


def _changed(kind, path, to=None):
    data = at = json.loads(whole(kind))
    for key in path[:-1]:
        at = at[key]
    at[path[-1]] = _other(at[path[-1]]) if to is None else to
    return data


def _replayed(data, tmp_path):
    (tmp_path / "c.json").write_bytes(seal(data))
    return replay_file(tmp_path / "c.json", registry())


def _is_told(found, path):
    """Whether a replay refuses it, says that something it depends on is other here, or names it as not played again."""
    name = ".".join(map(str, path))
    return (
        found.is_refused
        or any(name == it or name.startswith(f"{it.split()[0]}.") for it in found.unplayed)
        or (path[0] in ("runs_on", "place") and found.reasons != ())
    )


@pytest.mark.parametrize("kind", PLACES)
def test_each_changed_field_is_told_or_named_as_not_played_again(tmp_path, kind):
    """Each by itself: of an arm, of an environment, and where chance decides."""
    untold = []
    for path in _leaves(json.loads(whole(kind))):
        try:
            found = _replayed(_changed(kind, path), tmp_path)
        except HarnessError:  # in a line, before anything is played
            continue
        if not _is_told(found, path):
            untold.append(path)
    assert untold == []


@pytest.mark.parametrize("kind", PLACES)
def test_a_fresh_certificate_is_the_same(tmp_path, kind):
    """With no reason to doubt."""
    found = _replayed(json.loads(whole(kind)), tmp_path)
    assert (found.difference, found.reasons) == (None, ())


@pytest.mark.parametrize(
    ("path", "to", "told"),
    [
        (("behaviour", "measures", "distance", 10), 0.25, "number 11 of behaviour.measures.distance was 0.25, and is "),
        (("drawn", "qpos", "numbers", 30), 0.25, "number 31 of drawn.qpos.numbers was 0.25, and is "),
        (("role",), "success", "number 1 of role was 'success', and is 'failure' here"),
    ],
)
def test_what_people_look_at_is_compared(tmp_path, path, to, told):
    """The film of an arm, its measures and what it is said to be: the field is named with both values."""
    data = _changed("arm", path, to)
    data["answer"]["word"] = "PAYS FOR LOITERING"
    found = _replayed(data, tmp_path)
    assert found.lines[0].startswith(f"NOT THE SAME, refused. {told}")


def test_a_sum_that_is_none_of_its_steps_is_refused(tmp_path):
    """Before anything is played."""
    with pytest.raises(HarnessError, match=r"paid, total: it is 1000000\.0, and its steps come to "):
        _replayed(_changed("arm", ("paid", "total"), 1e6), tmp_path)


def test_a_forged_word_is_not_confirmed(tmp_path):
    """Only a search says it; the line says how to ask it again."""
    found = _replayed(_changed("arm", ("answer", "word"), "NOTHING FOUND"), tmp_path)
    assert found.lines[1].startswith(
        "Not played again, and not confirmed: answer, found, noise, film, role, place.horizon. "
    )
    assert found.lines[1].endswith(" --seed 3 --budget 100 --starts 1")
