"""robomimic's files become logs of steps; what does not fit together is refused.

The layout is that of https://robomimic.github.io/docs/datasets/overview.html.
"""

import json
from contextlib import contextmanager

import h5py
import numpy as np
import pytest

from harness.errors import SchemaError, UsageError
from harness_plugins.audit import audit_dataset
from tests.record.dataset.written import opened

LENGTHS = (3, 5, 4)
ARGS = {"env_name": "Lift", "env_type": 1, "env_kwargs": {"robots": ["Panda"]}}


def write(path, drop=(), masks=None, **attrs):
    """A file of three demonstrations, without what is dropped; `attrs` are those of ``data``."""
    rng = np.random.default_rng(0)
    with h5py.File(path, "w") as file:
        data = file.create_group("data")
        data.attrs.update({"total": sum(LENGTHS), "env_args": json.dumps(ARGS), **attrs})
        for number, steps in enumerate(LENGTHS):
            demo = data.create_group(f"demo_{number}")
            demo.attrs.update({"num_samples": steps, "model_file": "<mujoco/>", "is_success": number % 2})
            way, camera = rng.normal(size=(steps + 1, 3)), np.zeros((steps + 1, 4, 4, 3), np.uint8)
            told = {
                "obs/robot0_eef_pos": way[:-1], "next_obs/robot0_eef_pos": way[1:],
                "obs/agentview_image": camera[:-1], "next_obs/agentview_image": camera[1:],
                "actions": rng.uniform(-1.0, 1.0, (steps, 7)), "rewards": (np.arange(steps) == steps - 1) * 1.0,
                "dones": (np.arange(steps) == steps - 1).astype(int), "states": rng.normal(size=(steps, 9)),
            }  # fmt: skip
            for key, values in told.items():
                if not key.startswith(drop) or not drop:
                    demo[key] = values
        for key, names in (masks or {}).items():
            file[f"mask/{key}"] = np.array(names, dtype="S8")
    return f"robomimic:{path}"


def stored(path, key):
    """What stands in the file."""
    with h5py.File(path, "r") as file:
        return np.concatenate([np.asarray(file[f"data/demo_{number}/{key}"]) for number in range(len(LENGTHS))])


@contextmanager
def changing(folder):
    """A written file, open to be changed, and what names it."""
    text = write(folder / "d.hdf5")
    with h5py.File(folder / "d.hdf5", "a") as file:
        yield text, file


def test_a_log_holds_what_was_written(tmp_path):
    """What was seen before and after each step, what was done, and what was paid."""
    rows = opened(write(tmp_path / "d.hdf5")).rows()
    assert rows["episode"].tolist() == [0] * 3 + [1] * 5 + [2] * 4
    assert rows["step"].tolist() == [1, 2, 3, 1, 2, 3, 4, 5, 1, 2, 3, 4]
    columns = {
        "before/observation/robot0_eef_pos": "obs/robot0_eef_pos",
        "observation/robot0_eef_pos": "next_obs/robot0_eef_pos",
        "action": "actions",
        "reward/recorded": "rewards",
        "terminated": "dones",
    }
    for name, key in columns.items():
        assert np.array_equal(rows[name], stored(tmp_path / "d.hdf5", key)), name


def test_pictures_are_left_out_and_told(tmp_path):
    """The env is shown as text."""
    log = opened(write(tmp_path / "d.hdf5"))
    assert not any("image" in name for name in log.names)
    assert "Pictures and texts are left out: agentview_image" in log.facts.notes
    assert (log.facts.pictures_left_out, json.loads(log.facts.env)) == (True, ARGS)


def test_without_next_obs_the_last_step_is_not_seen(tmp_path):
    """The steps before it are followed by what the next one begins with."""
    rows = opened(write(tmp_path / "d.hdf5", drop=("next_obs",))).rows()
    seen = stored(tmp_path / "d.hdf5", "obs/robot0_eef_pos")
    last = np.isin(np.arange(len(seen)), np.cumsum(LENGTHS) - 1)
    assert rows["seen"].tolist() == (~last).tolist()
    assert np.array_equal(rows["observation/robot0_eef_pos"][~last], seen[1:][~last[:-1]])
    assert np.isnan(rows["observation/robot0_eef_pos"][last]).all()


def test_a_file_of_states_alone_has_steps_and_actions(tmp_path):
    """As robosuite's own script leaves it: neither rewards nor observations."""
    log = opened(write(tmp_path / "d.hdf5", drop=("obs", "next_obs", "rewards", "dones")))
    assert (log.rewards, len(log), log["action"].shape) == ((), 12, (12, 7))
    assert any(note.startswith("There are no numbers of obs") for note in log.facts.notes)


def test_an_attribute_tells_success(tmp_path):
    """Of the whole demonstration, in its last step; rewards and dones tell it if they are named."""
    text = write(tmp_path / "d.hdf5")
    told = opened(text)["behaviour/success"]
    assert told[[2, 7, 11]].tolist() == [0.0, 1.0, 0.0]
    assert np.isnan(np.delete(told, [2, 7, 11])).all()
    assert (
        opened(text, success="rewards")["behaviour/success"].tolist() == stored(tmp_path / "d.hdf5", "rewards").tolist()
    )


def test_a_filter_key_chooses_demonstrations(tmp_path):
    """All are read without one, which is told."""
    text = write(
        tmp_path / "d.hdf5", masks={"train": ["demo_0", "demo_2"], "valid": ["demo_1"], "lost": ["demo_0", "demo_9"]}
    )
    assert any(
        "All demonstrations are read" in note and "train 2, valid 1" in note for note in opened(text).facts.notes
    )
    log = opened(text.replace("robomimic:", "robomimic:mask=train:"))
    assert sorted({*log["episode"].tolist()}) == [0, 2]
    with pytest.raises(SchemaError, match="filter key lost lists demo_9, which is not there"):
        opened(text.replace("robomimic:", "robomimic:mask=lost:"))
    with pytest.raises(
        UsageError, match=r"filter keys, has no 'trian'. It has: lost, train, valid. Did you mean 'train'"
    ):
        opened(text.replace("robomimic:", "robomimic:mask=trian:"))


def test_another_total_is_refused(tmp_path):
    """Unless a part is enough."""
    text = write(tmp_path / "d.hdf5", total=13)
    with pytest.raises(SchemaError, match="13 steps declared, 12 there"):
        opened(text)
    assert len(opened(text, partial=True)) == 12


def test_a_file_is_audited_without_its_format(tmp_path):
    """A reward of the parts of an observation is paid each step."""
    write(tmp_path / "d.hdf5")
    found = audit_dataset(str(tmp_path / "d.hdf5"), {"up": lambda step: float(step.observation["robot0_eef_pos"][2])})
    returns = np.add.reduceat(stored(tmp_path / "d.hdf5", "next_obs/robot0_eef_pos")[:, 2], [0, 3, 8])
    (reward,) = found.rewards
    assert (found.facts.format, found.successes, found.failures) == ("robomimic", 1, 2)
    assert reward.by_success.value == pytest.approx(np.mean(returns[1] > returns[[0, 2]]))


def test_dones_in_the_middle_end_no_episode(tmp_path):
    """Where they say that the task is done by now, the demonstration goes on."""
    with changing(tmp_path) as (text, file):
        file["data/demo_1/dones"][:] = [0, 0, 1, 1, 1]
        file["data/demo_2/dones"][:] = [0, 1, 1, 0]
    log = opened(text)
    assert np.flatnonzero(log["terminated"]).tolist() == [2, 7]
    assert np.nansum(opened(text, success="dones")["behaviour/success"]) == 1 + 3 + 2


def test_demonstrations_are_found_by_their_numbers(tmp_path):
    """Also behind zeros; steps are those of the group of that name."""
    text = write(tmp_path / "d.hdf5")
    pay = stored(tmp_path / "d.hdf5", "actions")
    with h5py.File(tmp_path / "d.hdf5", "a") as file:
        file.move("data/demo_1", "data/demo_001")
    rows = opened(text).rows()
    assert rows["episode"].tolist() == [0] * 3 + [1] * 5 + [2] * 4
    assert np.array_equal(rows["action"], pay)


def test_the_env_is_told_on_one_line(tmp_path):
    """Robomimic's own script writes it with line breaks."""
    log = opened(write(tmp_path / "d.hdf5", env_args=json.dumps(ARGS, indent=4)))
    assert "\n" not in log.facts.env
    assert json.loads(log.facts.env) == ARGS


def put(key, values):
    """Changes a part of a demonstration."""

    def change(file):
        del file[f"data/demo_1/{key}"]
        if values is not None:
            file[f"data/demo_1/{key}"] = values

    return change


SEEN = "obs/robot0_eef_pos"
UNFIT = {
    "another length": (put("rewards", np.zeros(4)), "demo_1 has 5 actions, and 4 rows of reward"),
    "missing": (put("rewards", None), r"/data/demo_1 has no rewards"),
    "another shape": (
        put(f"next_{SEEN}", np.zeros((5, 4))),
        r"observation/robot0_eef_pos is \[5, 3\] in obs and \[5, 4\] in",
    ),
    "another file": (put(SEEN, h5py.ExternalLink("other.hdf5", "/x")), "not followed"),
    "another place": (put(SEEN, h5py.SoftLink("/data/demo_0/actions")), "not followed"),
    # Demonstrations of other names would be passed over
    "another name": (lambda file: file.move("data/demo_1", "data/episode_1"), "holds 'episode_1'"),
    "one number": (lambda file: file.move("data/demo_1", "data/demo_00"), "demo_0 and demo_00, which have one number"),
    # A file may declare names without a byte of them
    "many names": (
        lambda file: file.create_dataset("mask/train", (10**11,), "S8", chunks=(1000,)),
        "an array of names has 100,000,000,000, 2,000,000 are allowed",
    ),
}


@pytest.mark.parametrize(("change", "told"), UNFIT.values(), ids=UNFIT)
def test_what_does_not_fit_together_is_refused(tmp_path, change, told):
    """With the demonstration, and not what the file is, which the user said."""
    with changing(tmp_path) as (text, file):
        change(file)
    with pytest.raises(SchemaError, match=told):
        opened(text).rows()


def test_a_file_that_is_cut_is_told_so(tmp_path):
    """No format can say that it is its own."""
    write(tmp_path / "d.hdf5")
    whole = (tmp_path / "d.hdf5").read_bytes()
    (tmp_path / "d.hdf5").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(SchemaError, match=r"no readable HDF5 file: OSError: .*truncated file"):
        opened(str(tmp_path / "d.hdf5"))


def test_texts_without_a_length_are_refused(tmp_path):
    """HDF5's own library would never come back from them."""
    write(path := tmp_path / "d.hdf5")
    whole = bytearray(path.read_bytes())
    text = whole.index(json.dumps(ARGS).encode())
    whole[text - 8 : text] = (2**64 - 16).to_bytes(8, "little")
    path.write_bytes(whole)
    with pytest.raises(SchemaError, match=r"its texts at byte .* have no length"):
        opened(f"robomimic:{path}")
