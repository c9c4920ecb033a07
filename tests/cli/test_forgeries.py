"""Folders of somebody who recomputed every digest: absurd values are one damaged row, and nobody's traceback."""

import json
import shutil

import numpy as np
import pyarrow as pa
import pytest

import harness as program
from harness.files.bounded import machine_key, with_key
from tests.cli.forging import change, column, first_cell, in_manifest, in_plan, table

ROWS = 1_000_000
"""Of a trace of a cell that took 20 steps."""


@pytest.fixture(scope="module")
def genuine(tmp_path_factory):
    """An experiment that ran: two seeds of two rewards."""
    folder = tmp_path_factory.mktemp("genuine") / "it"
    program.run(
        sim="kinematic", algo="random", reward="dense", seeds=2, steps=20, evaluation_episodes=2, jobs=1, out=folder
    )
    return folder


@pytest.fixture
def folder(genuine, tmp_path):
    """A copy, without what reports keep."""
    return copied(genuine, tmp_path / "it")


def copied(genuine, folder):
    """The experiment once more, without what reports keep."""
    return shutil.copytree(genuine, folder, ignore=shutil.ignore_patterns("derived"))


def params(of, value):
    """The parameters of a plugin of a cell."""
    return lambda folder: change(
        first_cell(folder) / "manifest.json", lambda content: content["cell"][of].update(params=value)
    )


def repeated(found):
    """Many rows that take next to no room."""
    return found.take(pa.array(np.ones(ROWS, np.int64)))


ABSURD = {
    **{f"started {text}": in_manifest(started=text) for text in ("2026-01-01T00:00:00", "yesterday", "9" * 5000)},
    **{f"{key} 1e15": in_manifest(**{key: 1e15}) for key in ("seconds", "training_seconds")},
    "peak memory 1e30": in_manifest(peak_memory=10**30),
    "environment of other types": in_manifest(environment={"versions": [1], "machine": "x", "engine": {}}),
    "a file outside": in_manifest(files={"../../x": "0" * 64}),
    **{
        f"parameters {value} of the {of}": params(of, value)
        for of in ("reward", "task", "simulator", "algorithm")
        for value in ({"a": {}}, {"a": [[[1]]]}, [["a", {}]], {"a": "x" * 20_000})
        if of == "reward" or value == {"a": {}}  # all four are read by one function
    },
    "parameters in the plan": in_plan(lambda content: content["cells"][0]["reward"].update(params={"a": {}})),
    "an experiment of other types": in_plan(lambda content: content["experiment"].update(algo={"a": {}}, measure=3)),
    "looks of other types": in_plan(lambda content: content.update(terms={"looks": [1e308, "x"]})),
    **{
        f"{name} {value} in {file}": table(file, column(name, value))
        for file in ("trace.parquet", "evaluation.parquet")
        for name in ("reward", "distance")
        for value in (1e308, -1e200)
    },
    **{f"{name} -5": table("trace.parquet", column(name, -5)) for name in ("env", "step", "episode")},
    "no row": table("trace.parquet", lambda found: found.slice(0, 0)),
    "no row of an evaluation": table("evaluation.parquet", lambda found: found.slice(0, 0)),
    "more rows than steps": table("trace.parquet", repeated),
    "more rows than episodes": table("evaluation.parquet", repeated),
}


def test_absurd_values_are_foreseen(harness, genuine, tmp_path, subtests):
    """Damage is one row or one line; no command ends with what nobody foresaw, nor one that reads what another kept."""
    commands = [
        ("verify",),
        ("report", "--details"),
        ("report", "--json", "--summary", tmp_path / "records"),
    ]
    for name, forge in ABSURD.items():
        folder = copied(genuine, tmp_path / "it")
        forge(folder)
        for command, *words in commands:
            with subtests.test(name, words=(command, *words)):
                answer = harness(command, folder, *words)
                assert answer.status in (0, 1)
                assert "Traceback" not in answer.err
        for made in (folder, tmp_path / "records"):
            shutil.rmtree(made, ignore_errors=True)


@pytest.mark.parametrize(
    "name", ["more rows than steps", "no row", "started yesterday", "reward 1e+308 in trace.parquet"]
)
def test_the_other_cells_are_reported(harness, folder, name):
    """Three of the four; the damaged one says why."""
    ABSURD[name](folder)
    cells = harness("report", folder, "--json").json["cells"]
    assert sorted(cell["status"] for cell in cells) == ["damaged", *["done"] * 3]
    assert next(cell["reason"] for cell in cells if cell["status"] == "damaged")


def signed_by_another(path, content, monkeypatch, home):
    """A kept result as another machine would have written it, under the key of this one."""
    key = path.read_bytes().split(b"\n")[2].decode()
    with monkeypatch.context() as patch:
        patch.setenv("XDG_STATE_HOME", str(home))
        machine_key.cache_clear()
        path.write_bytes(with_key(key, content))
    machine_key.cache_clear()


def test_kept_results_of_another_machine_are_not_believed(harness, folder, tmp_path, monkeypatch):
    """Every number set to 1: the report is what it was."""
    expected = harness("report", folder, "--json").json
    for path in sorted((folder / "derived").glob("*/values")):
        forged = {name: [key, 1.0] for name, (key, _) in json.loads(path.read_bytes().split(b"\n", 3)[3]).items()}
        signed_by_another(path, json.dumps(forged).encode(), monkeypatch, tmp_path / "another")
    assert harness("report", folder, "--json").json == expected


def test_kept_results_of_another_machine_are_not_unpacked(harness, folder, tmp_path, monkeypatch):
    """A small file may unpack to gigabytes."""
    expected = harness("report", folder, "--json").json
    huge = pa.compress(bytes(2**27), codec="zstd", asbytes=True)
    with monkeypatch.context() as patch:
        patch.setattr(pa, "decompress", lambda *given, **more: pytest.fail("it was unpacked"))
        for path in sorted((folder / "derived").glob("*/*.array")):
            signed_by_another(path, (2**24).to_bytes(8, "little") + huge, monkeypatch, tmp_path / "another")
        assert harness("report", folder, "--json").json == expected
