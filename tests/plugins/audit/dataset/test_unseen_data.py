"""Data sets whose observations hold no numbers, or not under the usual name: recorded pay is judged all the same."""

import json

import numpy as np
import pytest
from numpy.random import default_rng

from harness.errors import SchemaError
from harness_plugins.audit import audit_dataset
from tests.record.dataset.frames import info_of, write_frames
from tests.record.dataset.written import opened, write_minari

COUNT, STEPS = 24, 6
PAID = default_rng(5).normal(size=(COUNT, STEPS)) + 0.2 * (np.arange(COUNT) % 2)[:, None]
WON = np.arange(COUNT) % 2 == 1
WHOLE = PAID.sum(axis=1)
AUC = float(np.mean(WHOLE[WON][:, None] > WHOLE[~WON][None, :]))
ACTION = default_rng(0).normal(size=(COUNT, STEPS, 2))


@pytest.fixture
def lerobot(tmp_path):
    """A LeRobot data set that holds what is given as seen."""

    def write(version="v3.0", reward="next.reward", **seen):
        episodes = [
            {**seen, "action": ACTION[it], reward: PAID[it], "next.success": np.full(STEPS, WON[it])}
            for it in range(COUNT)
        ]
        return write_frames(tmp_path / "d", episodes, version)

    return write


def shares(found):
    """How often a success is paid more, by reward."""
    return [it.by_success.value for it in found.rewards]


@pytest.mark.parametrize("version", ["v2.1", "v3.0"])
def test_recorded_pay_needs_no_observation(lerobot, version):
    """A set of videos alone has its answer, and nothing is said of standing still."""
    folder = lerobot(version)
    told = info_of(folder)
    told["features"]["observation.images.top"] = {"dtype": "video", "shape": [96, 96, 3], "names": None}
    (folder / "meta/info.json").write_text(json.dumps(told))
    found = audit_dataset(f"lerobot:{folder}")
    assert (shares(found), found.still.value) == ([pytest.approx(AUC)], None)
    assert any("There are no numbers of observation.state" in line for line in found.notes)


def swallows(observation, action, next_observation, info):
    """Looks at what was seen, and lets nobody know."""
    try:
        return float(observation[0])
    except Exception:
        return 0.0


def test_a_function_that_looks_at_nothing_is_refused_alone(lerobot):
    """One that looks at actions pays every step; one that looks at what is not there pays nothing, also unnoticed."""
    functions = {"a": lambda o, a, n, i: float(a[0]), "o": lambda o, a, n, i: float(np.sum(o)), "s": swallows}
    found = audit_dataset(f"lerobot:{lerobot()}", functions)
    done = np.float64(np.float32(ACTION[..., 0])).sum(axis=1)
    assert shares(found) == [pytest.approx(np.mean(done[WON][:, None] > done[~WON][None, :]))]
    assert set(found.failed) == {"o", "s"}
    assert all("observations of this data set hold no numbers" in why for why in found.failed.values())


def test_parts_of_an_observation_are_a_dictionary(lerobot):
    """Numbers under other names than observation.state are seen under these."""
    seen = {"observation.state.eef": np.ones((STEPS, 3)), "observation.environment_state": np.ones((STEPS, 2))}
    name, count = f"lerobot:{lerobot(**seen)}", STEPS * COUNT
    shapes = {key: of.shape for key, of in opened(name).rows().columns.items() if key.startswith("observation")}
    assert shapes == {"observation/environment_state": (count, 2), "observation/state.eef": (count, 3)}
    assert shares(audit_dataset(name)) == [pytest.approx(AUC)]


def test_pay_may_be_called_reward(lerobot):
    """A column `reward` is the recorded one where there is no `next.reward`."""
    folder = lerobot(reward="reward", **{"observation.state": np.ones((STEPS, 3))})
    assert shares(audit_dataset(f"lerobot:{folder}")) == [pytest.approx(AUC)]


@pytest.fixture
def games(tmp_path):
    """The audit of a Minari data set in which every episode looks alike."""

    def ask(seen, space, actions, rewards, success):
        episodes = [
            {"observations": seen, "actions": actions(it), "rewards": rewards(it), "attrs": {},
             "infos": {"success": success(it)}}
            for it in range(COUNT)
        ]  # fmt: skip
        folder = write_minari(tmp_path / "d", episodes, observation_space=json.dumps(space))
        return audit_dataset(f"minari:{folder}")

    return ask


TEXT, SENTENCES = {"type": "Text", "max_length": 9}, np.array([b"go there"] * (STEPS + 1))
WAY = {"type": "Discrete", "n": 4}


def parts(**subspaces):
    """A space of parts."""
    return {"type": "Dict", "subspaces": subspaces}


UNSEEN = {
    "pictures": (
        {"type": "Box", "dtype": "uint8", "shape": [80, 80, 3]}, np.zeros((STEPS + 1, 80, 80, 3), np.uint8)
    ),
    "texts": (TEXT, SENTENCES),
    "mission": (parts(mission=TEXT, direction=WAY), {"mission": SENTENCES, "direction": np.zeros(STEPS + 1, int)}),
}  # fmt: skip


@pytest.mark.parametrize(("space", "seen"), UNSEEN.values(), ids=UNSEEN)
def test_what_is_no_numbers_is_left_out_of_minari(games, space, seen):
    """Large pictures, texts, and a text beside numbers."""
    found = games(
        seen, space, lambda it: np.full(STEPS, it), PAID.__getitem__, lambda it: np.array([False] * STEPS + [WON[it]])
    )
    assert shares(found) == [pytest.approx(AUC)]
    assert any(line.startswith("Pictures and texts are left out: observations") for line in found.notes)


@pytest.mark.parametrize(("fraction", "left"), [(0, COUNT), (0.5, 2)])
def test_episodes_that_pictures_may_tell_apart_are_no_copies(games, fraction, left):
    """Whole numbers alone are equal by chance; fractions are not."""
    seen = {"camera": np.zeros((STEPS + 1, 3), np.uint8), "way": np.zeros(STEPS + 1, int)}
    space = parts(camera={"type": "Box", "dtype": "uint8", "shape": [1, 1, 3]}, way=WAY)
    found = games(
        seen, space, lambda it: np.full(STEPS, int(WON[it]) + fraction), lambda it: np.full(STEPS, float(WON[it])),
        lambda it: np.full(STEPS + 1, WON[it]),
    )  # fmt: skip
    assert found.episodes == left


def test_a_minari_data_set_in_another_format_is_called_so(tmp_path):
    """It is there, so that nobody is sent to fetch it."""
    write_minari(tmp_path / "d", [], data_format="arrow")
    with pytest.raises(SchemaError, match=r"the format 'arrow'.* data_format='hdf5'"):
        opened(f"minari:{tmp_path / 'd'}")
