"""Every simulator does the same twice: in this process and another one, after a reset, alone and in a batch."""

import hashlib
import json
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from numpy.random import default_rng
from numpy.testing import assert_array_equal

import harness
from harness.record import TraceWriter, read_trace
from tests.registered import REGISTRY

SIMULATORS = REGISTRY.names("simulators")
TASKS = {"driven": "fd100-reach:horizon=12,epsilon=0.15", "set": "unity-reach:horizon=17"}

pytestmark = [
    pytest.mark.usefixtures("installed"),
    pytest.mark.parametrize("simulator", SIMULATORS),
    pytest.mark.parametrize("task", TASKS.values(), ids=TASKS),
]


def record(simulator, task, envs=(0, 1), steps=40, *, before=0):
    """The trace of the envs of these numbers under actions of their own, after `before` steps of something else."""
    env = harness.make_env(simulator, task, "arp:k2=2", num_envs=len(envs))
    size = env.single_action_space.shape[0]
    with TemporaryDirectory() as folder:
        path = Path(folder) / "trace.parquet"
        if before:
            env.reset(seed=99)
            for _ in range(before):
                env.step(np.full((len(envs), size), 0.7, np.float32))
        with TraceWriter(path, env.robot.dof, size) as recorder:
            env.episodes.episode[...] = -1.0  # numbered anew
            env.recorder = recorder
            env.reset(seed=[[5, k] for k in envs])
            drawn = [default_rng([6, k]).uniform(-1.0, 1.0, (steps, size)) for k in envs]
            for actions in np.stack(drawn, axis=1).astype(np.float32):
                env.step(actions)
        env.close()
        return read_trace(path).load()


def assert_same(first, second):
    """All columns, bit for bit."""
    assert set(first.columns) == set(second.columns)
    for name, column in first.rows().columns.items():
        assert_array_equal(column, second[name], err_msg=name)


def digest(trace):
    """Of all columns."""
    parts = b"".join(name.encode() + column.tobytes() for name, column in sorted(trace.rows().columns.items()))
    return hashlib.sha256(parts).hexdigest()


def test_same_seed_same_trace(simulator, task):
    """Twice in one process."""
    first = record(simulator, task)
    assert len(first.last_rows) > 2
    assert_same(first, record(simulator, task))


def test_same_seed_same_trace_after_a_reset(simulator, task):
    """An arm that has moved before leaves no mark on what follows a reset."""
    assert_same(record(simulator, task), record(simulator, task, before=7))


@pytest.fixture(scope="module")
def told_elsewhere():
    """The digests of another process, by simulator and task."""
    code = (
        "import importlib.util, json, sys\n"
        f"spec = importlib.util.spec_from_file_location('determinism', {__file__!r})\n"
        "module = importlib.util.module_from_spec(spec)\n"
        "spec.loader.exec_module(module)\n"
        "names = [name for name in module.SIMULATORS if not module.REGISTRY.get('simulators', name).missing]\n"
        "pairs = [(simulator, task) for simulator in names for task in module.TASKS.values()]\n"
        "print(json.dumps({f'{pair}': module.digest(module.record(*pair)) for pair in pairs}))\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return json.loads(done.stdout.splitlines()[-1])


def test_same_seed_same_trace_in_another_process(simulator, task, told_elsewhere):
    """A process that was started for it has the same trace."""
    assert told_elsewhere[f"{(simulator, task)}"] == digest(record(simulator, task))


@pytest.mark.parametrize("num_envs", [1, 3, 8])
def test_env_of_a_batch_is_as_one_alone(simulator, task, num_envs):
    """Every arm of a batch leaves the rows that it leaves alone."""
    batch = record(simulator, task, tuple(range(num_envs)), steps=25)
    for k in {0, num_envs // 2, num_envs - 1}:
        alone, rows = record(simulator, task, (k,), steps=25), batch["env"] == k
        for name, column in alone.rows().columns.items():
            if name != "env":
                assert_array_equal(column, batch[name][rows], err_msg=name)
