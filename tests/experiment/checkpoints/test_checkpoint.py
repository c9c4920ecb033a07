"""A cell whose process is killed goes on from its last checkpoint, to the same end."""

import json

import numpy as np
import pytest
import safetensors.numpy
from numpy.random import default_rng
from numpy.testing import assert_array_equal

from harness.algorithm import pack_generator, restore_generator
from harness.errors import SchemaError
from harness.executor import CellOptions
from harness.experiment import provenance, run_cell as cell_progress
from harness.experiment.checkpoints.checkpoint import Checkpoint, read_checkpoint
from harness.experiment.experiment import ExperimentRun
from harness.experiment.run_cell import run_cell
from harness.record import (
    EVALUATION,
    LOG,
    POLICY,
    SCALARS,
    TRACE,
    EpisodeFacts,
    TraceWriter,
    partial_folder,
    read_manifest,
)
from harness.record.folder import WEIGHTS
from harness.record.parts import PART_ROWS
from harness.record.trace import require_rows
from harness.registry import Choice
from harness_plugins.executors.processes import Processes
from harness_plugins.kit.trainings import WatchedEnv
from tests.stores import create_store

ORIGIN = {"cell": "a", "versions": {"numpy": "2"}, "commit": "", "sources": {}}
FACTS = EpisodeFacts(horizon=5, control_period=0.1)


def _learner(name, steps=400, **settings):
    return {"algorithm": Choice(name, tuple(settings.items()), name), "steps": steps}


RANDOM = _learner("random", 3000)
LEARNERS = {
    "spg": _learner("spg", num_envs=5, decisions=8, restart=3),
    "sac-fast": _learner("sac-fast", learning_starts=50, buffer_size=130),
    "sac-fast, 3 envs": _learner("sac-fast", 399, learning_starts=50, num_envs=3, train_freq=2),
    "sb3-sac": _learner("sb3-sac", learning_starts=50, batch_size=32),
    "ppo": _learner("ppo", rollout=64, num_envs=2, schedule="linear"),
}
"""Cells whose trainings leave checkpoints in the middle of episodes."""


def _contents(folder):
    return [(folder / name).read_bytes() for name in (TRACE, EVALUATION, f"{POLICY}/{WEIGHTS}")]


def _checkpoint(**fields):
    given = {"steps": 7, "origin": ORIGIN, "algorithm": {"weight": np.arange(3.0)}, "env": {"count": np.array(5)}}
    return Checkpoint(**{**given, **fields})


# --------------------------------------------------------------------------------------------------- whole cells


@pytest.mark.parametrize(
    ("fields", "every", "kills"),
    [
        (RANDOM, 1000, (1300, 2200)),
        (RANDOM, 500, (2900,)),
        *(
            pytest.param(fields, 100, (300,), marks=[pytest.mark.slow] * (name != "sac-fast"))
            for name, fields in LEARNERS.items()
        ),
    ],
    ids=["twice", "near the end", *LEARNERS],
)
def test_killed_cell_ends_as_if_it_had_not_been(
    toys,
    train_in_a_process,
    make_cell,
    tmp_path,
    fields,
    every,
    kills,
):
    """Trace, evaluation and weights are, byte for byte, those of a cell that nobody killed."""
    cell = make_cell(**fields)
    run_cell(cell, tmp_path / "whole", lambda steps: None, CellOptions(0))
    for until in kills:
        train_in_a_process(cell, tmp_path / "killed", every, until)
        assert not (tmp_path / "killed").exists()
    train_in_a_process(cell, tmp_path / "killed", every)
    manifest = read_manifest(tmp_path / "killed")
    assert kills[-1] - 2 * every < manifest.resumed_from <= kills[-1]
    assert manifest.note == f"went on after {manifest.resumed_from} steps"
    assert _contents(tmp_path / "killed") == _contents(tmp_path / "whole")


@pytest.mark.parametrize(
    "name",
    [
        "spg",
        "sac-fast",
        "ppo",
        *(pytest.param(name, marks=pytest.mark.slow) for name in ("sac-fast, 3 envs", "sb3-sac")),
    ],
)
def test_checkpoints_change_nothing(toys, make_cell, tmp_path, name):
    """With checkpoints and without, every file is the same, byte for byte; nothing of them is left in the folder."""
    cell = make_cell(**LEARNERS[name])
    contents = []
    for every in (0, 100):
        folder = tmp_path / str(every)
        assert run_cell(cell, folder, lambda steps: None, CellOptions(every)).status == "done"
        contents.append((_contents(folder), {path.name for path in folder.iterdir()}))
    assert contents[0] == contents[1]


def test_kernels_that_trained_a_cell_are_recorded(toys, train_in_a_process, make_cell, tmp_path, monkeypatch):
    """In the manifest too, in their order."""
    cell, kernel = make_cell(**RANDOM), provenance.blas_kernel()
    train_in_a_process(cell, tmp_path / "killed", 500, 1300)
    monkeypatch.setattr(provenance, "blas_kernel", lambda: "of another CPU")
    manifest = run_cell(cell, tmp_path / "killed", lambda steps: None, CellOptions(500))
    assert manifest.environment["machine"]["kernel"] == f"{kernel} and then of another CPU"
    assert "of another CPU: no kernel alone gives these bytes" in manifest.note


def test_cell_without_a_checkpoint_starts_over_and_says_so(toys, train_in_a_process, make_cell, tmp_path):
    """An algorithm that writes none loses what it had done, and log and manifest tell."""
    waiting = Choice("wander", (("note", str(tmp_path / "note")), ("then", "wait")), "wander")
    train_in_a_process(make_cell(algorithm=waiting), tmp_path / "cell", 1, until=12)
    assert (partial_folder(tmp_path / "cell") / TRACE).exists()
    manifest = run_cell(make_cell(), tmp_path / "cell", lambda steps: None, CellOptions(1))
    assert (manifest.status, manifest.resumed_from) == ("done", 0)
    assert manifest.note == "started over: no checkpoint was left"
    assert "this one started over" in (tmp_path / "cell" / LOG).read_text()


def test_damaged_checkpoint_starts_over(toys, train_in_a_process, make_cell, tmp_path):
    """The cell is done all the same, from its beginning, and says why."""
    cell = make_cell(**RANDOM)
    train_in_a_process(cell, tmp_path / "cell", 1000, until=2500)
    path = partial_folder(tmp_path / "cell") / "checkpoint.safetensors"
    path.write_bytes(path.read_bytes()[:-3])
    manifest = run_cell(cell, tmp_path / "cell", lambda steps: None, CellOptions(1000))
    assert (manifest.status, manifest.resumed_from) == ("done", 0)
    assert manifest.note.startswith("started over: checkpoint.safetensors is of no use: ")
    run_cell(cell, tmp_path / "whole", lambda steps: None, CellOptions(1000))
    assert _contents(tmp_path / "cell") == _contents(tmp_path / "whole")


# -------------------------------------------------------------------------------------------------------- the file


def test_checkpoint_comes_back(tmp_path):
    """Numbers, arrays of any type, and what is said of them; a later one replaces it."""
    algorithm = {"done": np.array(7), "bytes": np.arange(3, dtype=np.uint8), "turned": np.ones((2, 3), np.float32).T}
    for steps in (6, 7):
        _checkpoint(steps=steps, algorithm=algorithm, seconds=1.5).write(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["checkpoint.safetensors"]
    back = read_checkpoint(tmp_path, ORIGIN)
    assert (back.steps, back.seconds, back.rows, int(back.env["count"])) == (7, 1.5, 0, 5)
    for name, array in algorithm.items():
        assert (back.algorithm[name].dtype, back.algorithm[name].shape) == (array.dtype, array.shape)
        assert_array_equal(back.algorithm[name], array)


@pytest.mark.parametrize("key", ORIGIN)
def test_other_origin_is_refused(tmp_path, key):
    """Neither another cell's checkpoint, nor one of other sources or versions, is gone on from."""
    _checkpoint().write(tmp_path)
    with pytest.raises(SchemaError, match="have changed since"):
        read_checkpoint(tmp_path, {**ORIGIN, key: "other"})


def test_checkpoint_that_cannot_be_read_is_refused(tmp_path):
    """A missing one, and one of a newer format: what it means is not known."""
    with pytest.raises(SchemaError, match="it cannot be read"):
        read_checkpoint(tmp_path, ORIGIN)
    safetensors.numpy.save_file(
        {}, tmp_path / "checkpoint.safetensors", {"harness.checkpoint": json.dumps({"format": 99})}
    )
    with pytest.raises(SchemaError, match="it has format 99, this version reads 3"):
        read_checkpoint(tmp_path, ORIGIN)


def test_every_flipped_byte_is_found(tmp_path):
    """Wherever it is, the checkpoint is refused."""
    _checkpoint(seconds=0.0).write(tmp_path)
    whole = (tmp_path / "checkpoint.safetensors").read_bytes()
    for at in range(len(whole)):
        flipped = bytearray(whole)
        flipped[at] ^= 1
        (tmp_path / "checkpoint.safetensors").write_bytes(flipped)
        with pytest.raises(SchemaError):
            read_checkpoint(tmp_path, ORIGIN)


# ------------------------------------------------------------------------------------------------- rows of the trace


TRACED = default_rng(0).random((3 * PART_ROWS + 100, len(SCALARS) + 4)).round(2)


@pytest.mark.parametrize("kept", [1, 3, PART_ROWS - 1, PART_ROWS, PART_ROWS + 1, 2 * PART_ROWS, 3 * PART_ROWS + 100])
def test_trace_that_goes_on_is_that_of_nobody_killed(tmp_path, kept):
    """Every file, byte for byte; rows behind those that were kept are forgotten, and so are parts."""
    contents = []
    for stops in ((), (kept, min(kept + PART_ROWS, len(TRACED)))):
        path = tmp_path / str(len(stops)) / TRACE
        path.parent.mkdir()
        if stops:
            before = TraceWriter(path, 2, 2, FACTS)
            before.append(TRACED[: stops[0]])
            assert before.keep() == kept
            before.append(TRACED[stops[0] : stops[1]])
            before.keep()
            require_rows(path, kept)
        with TraceWriter(path, 2, 2, FACTS, after=kept if stops else 0) as writer:
            for begin in range(kept if stops else 0, len(TRACED), 999):
                writer.append(TRACED[begin : begin + 999])
        contents.append({part.name: part.read_bytes() for part in path.parent.iterdir()})
    assert len(contents[0]) == 4
    assert contents[0] == contents[1]


def test_rows_that_are_not_as_they_were_written_are_noticed(tmp_path):
    """A byte that changed, or a file that is gone."""
    path = tmp_path / TRACE
    with TraceWriter(path, 2, 2, FACTS) as writer:
        writer.append(TRACED[: PART_ROWS + 9])
    require_rows(path, PART_ROWS + 9)
    later = path.with_name("trace-00001.parquet")
    for part in (path, later):
        whole = part.read_bytes()
        flipped = bytearray(whole)
        flipped[len(whole) // 3] ^= 1
        part.write_bytes(flipped)
        with pytest.raises(SchemaError):
            require_rows(path, PART_ROWS + 9)
        part.write_bytes(whole)
    later.unlink()
    with pytest.raises(SchemaError, match=r"has 65,536 rows, and 65,545 were written"):
        require_rows(path, PART_ROWS + 9)


# ------------------------------------------------------------------------------------------------- what is restored


def test_env_goes_on_as_it_would_have():
    """Starts, targets, numbers of episodes and the count of steps, from where its state was taken."""
    first, second = WatchedEnv(3), WatchedEnv(3)
    actions = np.ones((3, first.robot.dof), np.float32)
    first.reset(seed=3)
    for _ in range(30):
        first.step(actions)
    second.reset(seed=4)
    second.restore(first.state())
    assert second.environment_steps == first.environment_steps == 90
    for _ in range(2):
        assert_array_equal(first.reset()[0], second.reset()[0])
        for _ in range(25):
            assert_array_equal(first.step(actions)[0], second.step(actions)[0])
        assert_array_equal(first.episodes.matrix, second.episodes.matrix)


def test_generator_goes_on_as_it_would_have():
    """The same numbers follow."""
    first, second = default_rng(0), default_rng(1)
    first.normal(size=5)
    restore_generator(second, pack_generator(first))
    assert_array_equal(first.normal(size=5), second.normal(size=5))


@pytest.mark.parametrize("packed", [b"no json", b"[]", b'{"bit_generator": "MT19937"}'])
def test_state_of_no_such_generator_is_refused(packed):
    """With the kind that was expected."""
    with pytest.raises(SchemaError, match="no state of a PCG64"):
        restore_generator(default_rng(0), np.frombuffer(packed, np.uint8))


@pytest.mark.parametrize(
    ("seconds", "every", "count"), [(0.0, None, 400), (600.0, None, 0), (0.0, 0, 0), (0.0, 150, 2)]
)
def test_checkpoints_are_made_as_the_options_say(toys, make_cell, tmp_path, monkeypatch, seconds, every, count):
    """By the clock, which a cell of ten minutes outlasts, by steps, or not at all."""
    made = []
    write = Checkpoint.write

    def counted(self, folder):
        made.append(self.steps)
        write(self, folder)

    monkeypatch.setattr(cell_progress, "SECONDS", seconds)
    monkeypatch.setattr(Checkpoint, "write", counted)
    cell = make_cell(algorithm=Choice("random", (), "random"), steps=400)
    assert run_cell(cell, tmp_path / "cell", lambda steps: None, CellOptions(every)).status == "done"
    assert len(made) == count


def test_checkpoints_are_made_unless_somebody_says_otherwise():
    """A long cell that is killed does not start over."""
    assert (CellOptions().checkpoint_every, cell_progress.SECONDS) == (None, 600.0)


# -------------------------------------------------------------------------------------------------------- plans


@pytest.fixture
def store(make_cell, make_plan, tmp_path):
    """Of one cell."""
    return create_store(tmp_path, make_plan(make_cell()))


def _begun(store, cell, name="checkpoint.safetensors"):
    partial = partial_folder(store.cell_folder(cell))
    partial.mkdir()
    (partial / name).write_bytes(b"half")
    return partial


def test_run_keeps_what_can_be_gone_on_from(make_cell, store):
    """Partial folders with a checkpoint stay; others go."""
    kept, gone = _begun(store, make_cell()), _begun(store, make_cell(seed=1), TRACE)
    store.discard_partial()
    assert (kept.exists(), gone.exists()) == (True, False)


def test_cell_whose_process_alone_was_killed_is_reopened(make_cell, store):
    """It was recorded as failed, with its checkpoint: that is in the partial folder again."""
    cell = make_cell()
    _begun(store, cell)
    store.record(cell, "failed", "its process was ended by SIGKILL")
    assert {path.name for path in store.reopen(cell).iterdir()} == {"checkpoint.safetensors"}
    assert not store.cell_folder(cell).exists()


def test_failed_cell_without_a_checkpoint_stays(make_cell, store):
    """Until its next attempt replaces it."""
    store.record(make_cell(), "failed", "no luck")
    store.reopen(make_cell())
    assert read_manifest(store.cell_folder(make_cell())).reason == "no luck"


def test_run_tells_where_a_cell_went_on(
    train_in_a_process,
    toys,
    make_cell,
    make_plan,
    tmp_path,
):
    """Who follows the run hears what the manifest says of it."""
    cell = make_cell(**RANDOM)
    plan = make_plan(cell)
    store, notes = create_store(tmp_path, plan), []
    train_in_a_process(cell, store.cell_folder(cell), 1000, until=2500)
    ExperimentRun(plan, store, toys, Processes()).run(lambda event: notes.append(event.note))
    manifest = read_manifest(store.cell_folder(cell))
    assert manifest.note.startswith("went on after ")
    assert notes[-1] == manifest.note
