"""Data sets whose observations hold no numbers, or not under the usual name: recorded pay is judged all the same."""

import json
from pathlib import Path

import numpy as np
import pytest

from harness.errors import SchemaError
from harness_plugins.audit.dataset.audit_dataset import audit_dataset
from tests.record.dataset.frames import write_frames
from tests.record.dataset.written import opened, write_minari

COUNT, STEPS = 24, 6
PAID = np.random.default_rng(5).normal(size=(COUNT, STEPS)) + 0.2 * (np.arange(COUNT) % 2)[:, None]
WON = np.arange(COUNT) % 2 == 1
WHOLE = PAID.sum(axis=1)
AUC = float(np.mean(WHOLE[WON][:, None] > WHOLE[~WON][None, :]))


def frames(number: int, reward: str = "next.reward", **seen):
    """An episode of LeRobot that holds what is given as seen."""
    success = np.full(STEPS, WON[number])
    action = np.random.default_rng(number).normal(size=(STEPS, 2))
    return {**seen, "action": action, reward: PAID[number], "next.success": success}


def with_camera(folder: Path) -> Path:
    """Its metadata tells of a video."""
    path = folder / "meta" / "info.json"
    told = json.loads(path.read_text())
    told["features"]["observation.images.top"] = {"dtype": "video", "shape": [96, 96, 3], "names": None}
    path.write_text(json.dumps(told))
    return folder


def by_action(observation, action, next_observation, info):
    """Looks at what was done."""
    return float(action[0])


def by_observation(observation, action, next_observation, info):
    """Looks at what was seen."""
    return float(np.sum(observation))


def swallows(observation, action, next_observation, info):
    """Looks at what was seen, and lets nobody know."""
    try:
        return float(observation[0])
    except Exception:
        return 0.0


@pytest.mark.parametrize("version", ["v2.1", "v3.0"])
def test_recorded_pay_needs_no_observation(tmp_path: Path, version: str):
    """A set of videos alone has its answer, and nothing is said of standing still."""
    folder = with_camera(write_frames(tmp_path / "d", [frames(it) for it in range(COUNT)], version))
    found = audit_dataset(f"lerobot:{folder}")
    assert found.rewards[0].by_success.value == pytest.approx(AUC)
    assert found.still.mean is None
    assert any("There are no numbers of observation.state" in line for line in found.notes)


def test_a_function_that_looks_at_nothing_is_refused_alone(tmp_path: Path):
    """One that looks at actions pays every step; one that looks at what is not there pays nothing, also unnoticed."""
    folder = write_frames(tmp_path / "d", [frames(it) for it in range(COUNT)])
    functions = {"a": by_action, "o": by_observation, "s": swallows}
    found = audit_dataset(f"lerobot:{folder}", functions)
    done = np.array([float(np.float32(frames(it)["action"])[:, 0].sum()) for it in range(COUNT)])
    (answer,) = found.rewards
    assert answer.by_success.value == pytest.approx(np.mean(done[WON][:, None] > done[~WON][None, :]))
    assert set(found.failed) == {"o", "s"}
    assert all("observations of this data set hold no numbers" in why for why in found.failed.values())


def test_parts_of_an_observation_are_a_dictionary(tmp_path: Path):
    """Numbers under other names than observation.state are seen under these."""
    seen = {"observation.state.eef": np.ones((STEPS, 3)), "observation.environment_state": np.ones((STEPS, 2))}
    folder = write_frames(tmp_path / "d", [frames(it, **seen) for it in range(COUNT)])
    rows = opened(f"lerobot:{folder}").rows()
    shapes = {name: values.shape for name, values in rows.columns.items() if name.startswith("observation")}
    count = STEPS * COUNT
    assert shapes == {"observation/environment_state": (count, 2), "observation/state.eef": (count, 3)}
    assert audit_dataset(f"lerobot:{folder}").rewards[0].by_success.value == pytest.approx(AUC)


def test_pay_may_be_called_reward(tmp_path: Path):
    """A column `reward` is the recorded one where there is no `next.reward`."""
    seen = {"observation.state": np.ones((STEPS, 3))}
    folder = write_frames(tmp_path / "d", [frames(it, "reward", **seen) for it in range(COUNT)])
    assert audit_dataset(f"lerobot:{folder}").rewards[0].by_success.value == pytest.approx(AUC)


def games(seen, actions):
    """Episodes of Minari."""
    return [
        {
            "observations": seen(it),
            "actions": actions(it),
            "rewards": PAID[it],
            "infos": {"success": np.array([False] * STEPS + [WON[it]])},
            "attrs": {},
        }
        for it in range(COUNT)
    ]


@pytest.mark.parametrize("kind", ["pictures", "texts", "mission"])
def test_what_is_no_numbers_is_left_out_of_minari(tmp_path: Path, kind: str):
    """Large pictures, texts, and a text beside numbers."""
    text = {"type": "Text", "max_length": 9}
    spaces = {
        "pictures": {"type": "Box", "dtype": "uint8", "shape": [80, 80, 3]},
        "texts": text,
        "mission": {"type": "Dict", "subspaces": {"mission": text, "direction": {"type": "Discrete", "n": 4}}},
    }
    seen = {
        "pictures": np.zeros((STEPS + 1, 80, 80, 3), np.uint8),
        "texts": np.array([b"go there"] * (STEPS + 1)),
        "mission": {"mission": np.array([b"go there"] * (STEPS + 1)), "direction": np.zeros(STEPS + 1, int)},
    }
    made = games(lambda _: seen[kind], lambda it: np.full(STEPS, it))
    folder = write_minari(tmp_path / "d", made, observation_space=json.dumps(spaces[kind]))
    found = audit_dataset(f"minari:{folder}")
    assert found.rewards[0].by_success.value == pytest.approx(AUC)
    assert any(line.startswith("Pictures and texts are left out: observations") for line in found.notes)


@pytest.mark.parametrize(("fraction", "left"), [(0.0, COUNT), (0.5, 2)])
def test_episodes_that_pictures_may_tell_apart_are_no_copies(tmp_path: Path, fraction: float, left: int):
    """Whole numbers alone are equal by chance; fractions are not."""
    made = [
        {**one, "rewards": np.full(STEPS, float(WON[it])), "infos": {"success": np.full(STEPS + 1, WON[it])}}
        for it, one in enumerate(
            games(lambda _: {"camera": np.zeros((STEPS + 1, 3), np.uint8), "way": np.zeros(STEPS + 1, int)},
                  lambda it: np.full(STEPS, WON[it] + fraction) if fraction else np.full(STEPS, int(WON[it])))
        )
    ]  # fmt: skip
    camera = {"type": "Box", "dtype": "uint8", "shape": [1, 1, 3]}
    space = {"type": "Dict", "subspaces": {"camera": camera, "way": {"type": "Discrete", "n": 4}}}
    folder = write_minari(tmp_path / "d", made, observation_space=json.dumps(space))
    assert audit_dataset(f"minari:{folder}").episodes == left


def test_a_minari_data_set_in_another_format_is_called_so(tmp_path: Path):
    """It is there, so that nobody is sent to fetch it."""
    (tmp_path / "d" / "data").mkdir(parents=True)
    told = {"data_format": "arrow", "minari_version": "0.5.4"}
    (tmp_path / "d" / "data" / "metadata.json").write_text(json.dumps(told))
    with pytest.raises(SchemaError, match=r"the format 'arrow'.* data_format='hdf5'"):
        opened(f"minari:{tmp_path / 'd'}")
