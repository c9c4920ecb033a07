"""The file that stable-baselines3's EvalCallback writes, and what happens to such files."""

import warnings
import zipfile

import numpy as np
import pytest

from harness.errors import SchemaError
from tests.plugins.logs.reading import Reader

read = Reader("evaluations")


def saved(folder, **arrays):
    """A file with these arrays."""
    path = folder / "evaluations.npz"
    np.savez(path, **arrays)
    return path


@pytest.mark.parametrize("ways", [1, 2])
def test_the_callback_of_the_library_is_read_as_it_holds_its_results(counted, tmp_path, ways):
    """Of one env for the evaluations and of two, against the callback's own lists."""
    pytest.importorskip("stable_baselines3", reason="needs the extra sb3")
    from stable_baselines3 import A2C
    from stable_baselines3.common.callbacks import EvalCallback
    from stable_baselines3.common.env_util import make_vec_env

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        callback = EvalCallback(
            make_vec_env(counted, n_envs=ways), n_eval_episodes=4, eval_freq=10, log_path=str(tmp_path), verbose=0
        )
        A2C("MlpPolicy", make_vec_env(counted), n_steps=5, device="cpu").learn(30, callback=callback)
    log = read(tmp_path / "evaluations.npz")
    assert (
        log["time"].tolist()
        == np.repeat(callback.evaluations_timesteps, 4).tolist()
        == np.repeat([10, 20, 30], 4).tolist()
    )
    assert log["reward/recorded"] == pytest.approx(np.ravel(callback.evaluations_results), abs=1e-6)
    assert log["length"].tolist() == np.ravel(callback.evaluations_length).tolist()
    assert log["behaviour/success"].tolist() == np.ravel(callback.evaluations_successes).tolist()
    assert log.facts.evaluation
    assert log.facts.unit == "episode"


def test_a_file_without_lengths_and_successes_has_returns(tmp_path):
    """As old versions wrote it, and environments that tell no success."""
    log = read(saved(tmp_path, timesteps=[5, 9], results=[[1.0, 2.0], [3.0, 4.0]]))
    assert log.columns == ("time", "reward/recorded")
    assert log["reward/recorded"].tolist() == [1.0, 2.0, 3.0, 4.0]


def test_successes_of_other_episodes_are_left_out_and_told(tmp_path):
    """Where not every evaluation has them, nobody knows whose they are."""
    log = read(saved(tmp_path, timesteps=[5, 9], results=[[1.0, 2.0], [3.0, 4.0]], successes=[[True, False]]))
    assert log.measures == ()
    assert any("successes are (1, 2), results (2, 2)" in note for note in log.facts.notes)


def test_arrays_that_say_no_evaluations_are_refused(tmp_path_factory, subtests):
    """With the reason."""
    rows = [
        ({"timesteps": [5, 9], "results": [[1.0]]}, r"its results are \(1, 1\) of 2 evaluations"),
        ({"timesteps": [], "results": np.empty((0, 3))}, "of 0 evaluations"),
        ({"timesteps": [5, 9], "results": [[1.0], [np.nan]]}, "missing or not finite"),
        ({"timesteps": [5, 9], "results": [[1.0], [2.0]], "successes": [[0.5], [1.0]]}, "neither 0 nor 1"),
        ({"timesteps": [5, 9], "results": [["a"], ["b"]]}, "its results are no numbers"),
        ({"timesteps": [9, 5], "results": [[1.0], [2.0]]}, "evaluation 2 goes from step 9 to 5"),
        # No pickle is opened: an array of objects runs code when it is loaded
        ({"timesteps": [5], "results": np.array([[1.0, print]], dtype=object)}, "allow_pickle=False"),
    ]
    for arrays, why in rows:
        with subtests.test(arrays=arrays, why=why):
            tmp_path = tmp_path_factory.mktemp("case")
            with pytest.raises(SchemaError, match=why):
                read(saved(tmp_path, **arrays))


def test_a_file_that_is_cut_is_refused(tmp_path):
    """It is written anew at each evaluation."""
    path = saved(tmp_path, timesteps=[5, 9], results=[[1.0], [2.0]])
    path.write_bytes(path.read_bytes()[:-40])
    assert not read.is_recognised(path)
    with pytest.raises(SchemaError, match=r"no readable evaluations\.npz"):
        read.make().read(path)


def test_a_file_that_unpacks_to_more_than_is_allowed_is_refused(tmp_path, monkeypatch):
    """A few bytes of a zip can hold many."""
    path = tmp_path / "evaluations.npz"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("timesteps.npy", b"0" * 100_000)
        archive.writestr("results.npy", b"0")
    monkeypatch.setattr("harness_plugins.logs.evaluations.MOST_BYTES", 10_000)
    with pytest.raises(SchemaError, match="unpacks to 100,001 bytes"):
        read(path)


def test_arrays_of_others_are_not_recognised(tmp_path):
    """A data set, and a zip that is none."""
    np.savez(tmp_path / "data.npz", observations=[1.0], rewards=[2.0])
    (tmp_path / "e.npz").write_bytes(b"PK\x03\x04 and no more")
    for path in tmp_path.iterdir():
        assert not read.is_recognised(path)
