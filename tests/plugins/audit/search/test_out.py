"""What a search leaves in a folder is played again in another process, bit for bit, and shown without running it."""

import json
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from harness import load_registry
from harness.errors import SchemaError
from harness.files.bounded import seal, unseal
from harness.registry import choose, read_given
from harness_plugins.audit import page_in, read_certificate, replay_file, write_certificate, write_found
from harness_plugins.audit.search.behaviour import Behaviour, Searched
from harness_plugins.audit.search.finding import Finding
from harness_plugins.audit.search.out import certificates_of
from harness_plugins.audit.search.place import Place, places_in_environment, places_on_task, world_at
from tests.plugins.audit.search.certified import certificate_of
from tests.refusals import refused

DOCKING = "tests.plugins.audit.search.docking:Docking"
IDS = ("Pendulum-v1", "CartPole-v1", "FrozenLake-v1")
REWARDS = """
def calm(observation, action, next_observation, info):
    return {"height": float(next_observation[0]), "effort": -0.1 * float(action[0]) ** 2}
"""


@pytest.fixture(scope="module")
def registry():
    """With the docking task."""
    return load_registry(given=read_given([DOCKING]))


def found_at(place, registry, seed=5, start=7):
    """A finding that shows random actions in a place."""
    world = world_at(place, registry)
    world.space.seed(seed)
    shown = world.show(start, np.array([world.space.sample() for _ in range(world.horizon)], world.space.dtype))
    world.close()
    total, steps = float(shown.paid.sum()), len(shown.paid)
    three = {"failure": Behaviour(start, shown.actions, total, 0.0, False, steps, steps, 0.0)}
    searched = Searched((), (), (0.0,), (0.0,), (0,), (0.0,), 100, ("sequences",))
    lines = (f"The best-paid failure earns {total:.3g}.",)
    return Finding(
        place.name, place.reward.label, place.gamma, world.success, "CANNOT TELL", "", lines, (), (start,), searched,
        (), {}, {"failure": shown}, three,
    )  # fmt: skip


def in_environment(name, reward, registry, gamma=0.99):
    """A place in an environment."""
    return places_in_environment(registry, choose(registry, "environments", name), [reward], gamma)[0]


def left(folder, places, registry):
    """Leave what is found in some places."""
    made, refused = certificates_of(
        [found_at(place, registry) for place in places], places, registry, seed=3, budget=100
    )
    write_found(folder, made, registry, refused)
    return made, refused


@pytest.fixture(scope="module")
def docked(tmp_path_factory, registry):
    """A folder with what was found in the docking task."""
    folder = tmp_path_factory.mktemp("docked") / "new"
    left(folder, [in_environment("Docking", "near", registry)], registry)
    return folder


AGAIN = f"""
import sys
from pathlib import Path
from harness.registry.given import read_given
from harness.registry.registry import load_registry
from harness_plugins.audit.search.out import replay_file
registry = load_registry(given=read_given(["{DOCKING}"]))
for path in sys.argv[1:]:
    found = replay_file(Path(path), registry)
    print(found.difference, found.lines)
"""


@pytest.fixture
def no_films(monkeypatch):
    """Nothing is drawn, which takes a process of its own."""
    monkeypatch.setattr("harness_plugins.audit.search.out.films_of", lambda *given: [None] * len(given[-1]))


def test_another_process_is_paid_the_same_from_the_file(tmp_path, registry, no_films):
    """Bit for bit: an arm, three environments, one whose observations are dicts."""
    places = [
        *places_on_task(registry, [choose(registry, "rewards", "arp")], "fd100-reach", None, None, 0.95),
        *(in_environment(f"gymnasium:id={name}", "own", registry) for name in IDS),
        in_environment("Docking", "near", registry),
    ]
    paths = []
    for number, place in enumerate(places):
        made, refused = certificates_of([found_at(place, registry)], [place], registry, seed=3, budget=100)
        assert refused == []
        paths.append(tmp_path / f"{number}.json")
        write_certificate(made[0], paths[-1])
    told = subprocess.run(
        [sys.executable, "-c", AGAIN, *map(str, paths)], capture_output=True, text=True, check=True
    ).stdout.splitlines()  # fmt: skip
    assert len(told) == len(places)
    assert all(line.startswith("None ('the same: ") for line in told), told


def test_a_folder_holds_certificates_and_their_page(docked):
    """Named by reward and role."""
    assert sorted(path.name for path in docked.iterdir()) == ["index.html", "near-failure.json"]
    assert "harness audit --replay near-failure.json" in (docked / "index.html").read_text()


def test_a_film_is_drawn_by_the_environment(docked):
    """A picture of the start and of each step, 30 x 20 pixels."""
    film = read_certificate(docked / "near-failure.json").film
    assert film.reason == ""
    assert film.steps == tuple(range(13))
    assert film.size == (200, 133)
    assert film.strip.startswith(b"RIFF")


def test_the_next_search_replaces_the_one_before(docked, registry):
    """A role that is not found any more is gone; a file of somebody else stays."""
    made = read_certificate(docked / "near-failure.json")
    write_found(docked, [replace(made, role="success")], registry)
    (docked / "near-fastest.json").write_text("{}")
    write_found(docked, [made], registry)
    assert sorted(path.name for path in docked.iterdir()) == ["index.html", "near-failure.json", "near-fastest.json"]
    (docked / "near-fastest.json").unlink()


def test_the_page_of_a_folder_is_made_of_the_files_alone(docked, monkeypatch):
    """Nothing is run: no registry, no world."""
    for name in ("world_at", "load_robot", "films_of", "runs_on"):
        monkeypatch.setattr(f"harness_plugins.audit.search.out.{name}", None)
    page = page_in(docked)
    assert "data:image/webp;base64," in page
    assert page == page_in(docked / "near-failure.json")


def test_a_folder_without_certificates_has_no_page(tmp_path):
    """Whatever else lies there, an index.html too."""
    (tmp_path / "index.html").write_text("<script>alert(1)</script>")
    (tmp_path / "a.json").write_text("{}")
    assert page_in(tmp_path) is None


def test_a_damaged_certificate_is_left_out_and_told(tmp_path, docked):
    """The others are shown."""
    content = (docked / "near-failure.json").read_bytes()
    (tmp_path / "a.json").write_bytes(content)
    (tmp_path / "b.json").write_bytes(content[:-30])
    assert "Left out: " in page_in(tmp_path)


def test_a_link_is_not_followed(tmp_path, docked):
    """Neither when a folder is shown nor when one is written."""
    (tmp_path / "a.json").symlink_to(docked / "near-failure.json")
    assert page_in(tmp_path) is None
    with refused("is a link"):
        write_found(tmp_path, [certificate_of()], load_registry())


def test_a_changed_reward_is_refused_at_its_step(tmp_path, no_films):
    """Of a plugin file, which has to be given by hand; the hash says that it is another one."""
    file = tmp_path / "calm.py"
    file.write_text(REWARDS)
    registry = load_registry(given=read_given([str(file)]))
    (made,), _ = left(tmp_path / "out", [in_environment("gymnasium:id=Pendulum-v1", "calm", registry)], registry)
    path = tmp_path / "out/calm-failure.json"
    assert made.place.plugins[0]["path"] == "calm.py"
    with refused(r"The certificate needs the plugin calm.py \(SHA-256 .*give --plugin calm.py"):
        replay_file(path, load_registry())
    file.write_text(REWARDS.replace("-0.1 * ", "-0.125 * "))
    found = replay_file(path, load_registry(given=read_given([str(file)])))
    assert found.is_refused
    assert (found.difference.field, found.difference.number) == ("paid.terms.effort", 1)
    assert found.reasons[0].startswith("number 1 of sources.reward was ")
    assert found.reasons[1].startswith("No plugin that is given is {'path': 'calm.py', ")


def test_waves_that_no_seed_tells_are_not_certified(registry, tmp_path):
    """The behaviour does not repeat, and the reason says where."""
    made, refused = left(tmp_path / "out", [in_environment("Docking:waves=0.01", "shaped", registry)], registry)
    assert made == []
    assert "shaped, failure: not certified. Played again, number 1 of paid." in refused[0]
    assert "not certified" in (tmp_path / "out/index.html").read_text()


@pytest.mark.parametrize(
    ("keys", "to"),
    [
        (("actions", "numbers"), [5.0] * 24),
        (("actions",), {"type": "int64", "shape": [12], "numbers": [1] * 12}),
        (("actions",), {"type": "float32", "shape": [12, 3], "numbers": [0.0] * 36}),
    ],
)
def test_actions_that_the_world_does_not_take_are_refused(tmp_path, docked, registry, keys, to):
    """Beyond the bounds, of another type, of another size; the env is not asked."""
    data = unseal((docked / "near-failure.json").read_bytes())
    at = data
    for key in keys[:-1]:
        at = at[key]
    at[keys[-1]] = to
    (tmp_path / "c.json").write_bytes(seal(data))
    with pytest.raises(SchemaError, match="holds actions that Docking does not take"):
        replay_file(tmp_path / "c.json", registry)


def test_a_module_is_not_imported_because_a_file_names_it(tmp_path, monkeypatch):
    """A stranger's id with a module needs --allow-import."""
    monkeypatch.delenv("HARNESS_ALLOW_IMPORT", raising=False)
    registry = load_registry()
    task = choose(registry, "environments", "gymnasium:id=Pendulum-v1")
    evil = replace(task, params=tuple((key, "evil:X-v0" if key == "id" else it) for key, it in task.params))
    write_certificate(certificate_of(place=Place(evil, task, gamma=0.9, horizon=20)), tmp_path / "c.json")
    with refused("--allow-import evil"):
        replay_file(tmp_path / "c.json", registry)


def test_what_cannot_be_replayed_is_told(tmp_path, docked, registry):
    """No file, and a simulator for an environment."""
    with refused("there is no such file"):
        replay_file(tmp_path / "none.json", registry)
    with refused("--sim does not go with"):
        replay_file(docked / "near-failure.json", registry, "mujoco")


def test_the_file_is_plain_and_short(docked):
    """What a reader wants to know stands at its top."""
    data = json.loads((docked / "near-failure.json").read_text())
    assert list(data)[:6] == ["format", "what", "role", "answer", "place", "runs_on"]
    assert data["runs_on"]["versions"].keys() >= {"python", "numpy", "gymnasium"}
    assert data["runs_on"]["sources"].keys() == {"environment", "reward"}
