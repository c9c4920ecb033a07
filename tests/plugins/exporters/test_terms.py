"""Exported data sets and CSV files have a column for each term of a reward, beside the total."""

import csv
import json
from pathlib import Path

import h5py
import numpy as np
import pyarrow.parquet as pq
import pytest

import harness
from harness.cli import main
from harness.record.folder import TRACE
from harness.record.trace import read_trace, terms_of
from harness.results import load_results
from tests.results.gentle import GENTLE, run_gentle

TERMS = ["reach", "effort", "dock"]


@pytest.fixture(scope="module")
def ran(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A reward with terms, alone."""
    return run_gentle(tmp_path_factory.mktemp("terms"), reward=["gentle"], baseline="none", seeds=1)


@pytest.fixture(scope="module")
def recorded(ran: Path) -> dict[str, np.ndarray]:
    """What the terms paid the first episode of its training."""
    results = load_results(ran)
    trace = read_trace(results.store.cell_folder(results.done_cells[0]) / TRACE)
    rows = trace.episodes[0][1:]
    return {name: values[rows] for name, values in terms_of(trace).items()}


def _export(ran: Path, *flags: object) -> None:
    with pytest.raises(SystemExit) as stopped:
        main(["export", str(ran), *map(str, flags), "--plugin", str(ran.parent / GENTLE)])
    assert not stopped.value.code


def test_minari_has_a_column_of_infos_for_each_term(ran: Path, recorded: dict[str, np.ndarray]):
    """The metadata says which is which; the terms add up to the reward."""
    _export(ran, "--minari", ran.parent / "minari")
    (folder,) = (ran.parent / "minari").glob("**/training-v0")
    told = json.loads((folder / "data" / "metadata.json").read_text())
    assert told["harness_terms"] == {f"reward_0_term_{place}": f"gentle/{name}" for place, name in enumerate(TERMS)}
    with h5py.File(folder / "data" / "main_data.hdf5") as file:
        infos = file["episode_0/infos"]
        for place, name in enumerate(TERMS):
            np.testing.assert_array_equal(infos[f"reward_0_term_{place}"][1:], recorded[name])
        np.testing.assert_allclose(sum(infos[f"reward_0_term_{place}"][:] for place in range(3)), infos["reward_0"][:])


def test_a_reward_whose_file_is_missing_is_left_out(ran: Path, capsys: pytest.CaptureFixture[str]):
    """What to do about it is said."""
    with pytest.raises(SystemExit):
        main(["export", str(ran), "--minari", str(ran.parent / "without")])
    told = " ".join(capsys.readouterr().err.split())
    assert "reward gentle is left out: No reward 'gentle'." in told
    assert "If it stands in a file, add --plugin FILE" in told


def test_lerobot_has_a_feature_for_each_term(ran: Path, recorded: dict[str, np.ndarray]):
    """In float32, as all of its numbers."""
    _export(ran, "--lerobot", ran.parent / "lerobot")
    (folder,) = (ran.parent / "lerobot").glob("**/training-v0")
    info = json.loads((folder / "meta" / "info.json").read_text())
    assert list(info["harness_terms"].values()) == [f"gentle/{name}" for name in TERMS]
    (part,) = (folder / "data").glob("**/*.parquet")
    table = pq.read_table(part)
    for column, title in info["harness_terms"].items():
        values = recorded[title.partition("/")[2]]
        assert info["features"][column]["dtype"] == "float32"
        np.testing.assert_allclose(table.column(column).to_numpy()[: len(values)], values, rtol=1e-6)


def test_csv_has_a_column_for_each_term(ran: Path):
    """Behind the others, and exact."""
    with pytest.raises(SystemExit):
        main(["export", str(ran), "--csv", "--out", str(ran.parent / "csv")])
    (path,) = (ran.parent / "csv").glob("**/seed-0.csv")
    rows = list(csv.DictReader(path.read_text().splitlines()))
    assert list(rows[0])[-3:] == [f"reward/{name}" for name in TERMS]
    results = load_results(ran)
    trace = read_trace(results.store.cell_folder(results.done_cells[0]) / TRACE)
    assert [float(row["reward/effort"]) for row in rows] == (terms_of(trace)["effort"] + 0.0).tolist()


def test_without_terms_nothing_is_told_of_any(tmp_path: Path):
    """The metadata of other rewards stays as it was."""
    harness.run(sim="kinematic", algo="random", seeds=1, steps=60, evaluation_episodes=1, out=tmp_path / "run", jobs=1)
    with pytest.raises(SystemExit):
        main(["export", str(tmp_path / "run"), "--minari", str(tmp_path / "minari")])
    for path in (tmp_path / "minari").glob("**/metadata.json"):
        assert "harness_terms" not in json.loads(path.read_text())
