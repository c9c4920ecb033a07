"""What holds for all registered formats of logs."""

import os

import numpy as np
import pytest

from harness.errors import HarnessError
from harness.log import open_logs
from tests.plugins.logs.reading import FORMATS
from tests.registered import REGISTRY

STRIDE = 7
"""Bytes from one cut to the next; rows are longer."""
FOREIGN = ("table", "evaluations", "tensorboard")


@pytest.fixture(params=FOREIGN)
def made(request, tmp_path):
    """The name of a format, and its example."""
    return request.param, FORMATS[request.param].write_example(tmp_path)


def test_an_example_is_recognised_by_its_own_format_alone(made):
    """Nobody has to say what it is."""
    name, path = made
    head = path.read_bytes()[:4096] if path.is_file() else b""
    assert [other for other, it in FORMATS.items() if it.recognises(path, head)] == [name]


HEADS = {
    "an episode once in each run": ("run,episode,reward", "a,0,-1", "a,1,-2", "b,0,-1"),
    "an episode once in each seed": ("seed,episode,reward", "3,0,-1", "3,1,-2", "8,0,-1"),
    "an episode once in each env": ("env,episode,reward,length", "0,0,-1,200", "1,0,-1,200", "0,1,-2,190"),
    "a counter that rises by a length": ("episode,reward,total_steps", "0,-1,200", "1,-2,390"),
    "one episode": ("episode,reward,length", "0,-19,200"),
    "one episode without a length": ("episode,reward", "0,-19"),
    "pandas numbers the rows": (",episode,reward", "0,0,-19", "1,1,-18"),
    "lengths alone": ("reward,length", "-19,200", "-18,200"),
    "lengths that only rise": ("reward,length", "-19,200", "-18,390"),
}
"""Beginnings of tables of episodes."""
OF_STEPS = {
    "a counter": ("t,reward", "0,0", "1,0.5"),
    "several steps an episode": ("episode,reward", "0,0.5", "0,0.5", "1,0.5"),
    "steps of envs": ("env,episode,reward", "0,0,1", "1,0,1", "0,0,1"),
    "a counter of all episodes": ("episode,global_step,reward", "0,1,1", "0,2,1", "1,3,1"),
    "lengths so far": ("reward,length", "1,1", "1,2", "1,3"),
    "observations": ("episode,obs_0,reward", "0,0.5,1", "1,0.5,1"),
    "how it ended": ("episode,reward,terminated", "0,1,1", "1,1,1"),
    "two counts": ("step,episode,reward", "1,0,0.5", "1,1,0.5"),
}
"""Beginnings of tables of steps."""


@pytest.mark.parametrize(
    ("rows", "name"),
    [*((rows, "table") for rows in HEADS.values()), *((rows, "steps-csv") for rows in OF_STEPS.values())],
    ids=[*HEADS, *OF_STEPS],
)
def test_a_table_is_recognised_by_one_format_alone(tmp_path, rows, name):
    """Whoever reads all logs of a folder would read it twice."""
    path = tmp_path / "it.csv"
    path.write_text("\n".join([*rows, ""]))
    assert [other for other, it in FORMATS.items() if it.recognises(path, path.read_bytes())] == [name]


def test_an_example_has_returns_or_success_in_every_row(made):
    """Through the door that all logs come in by, with finite numbers."""
    for log in open_logs(made[1], REGISTRY):
        assert len(log) > 1
        assert "reward/recorded" in log
        assert all(np.isfinite(log[column]).all() for column in log.columns if column != "since")
        assert log.facts.unit in ("episode", "point")


def read_or_refused(name, path):
    """The logs of a damaged file; none if it is refused, in one line that names it."""
    try:
        return tuple(FORMATS[name].read(path))
    except HarnessError as error:
        sentence = str(error)
    assert str(path) in sentence
    assert "\n" not in sentence
    return ()


def test_a_cut_file_is_refused_or_has_the_first_rows(made):
    """Wherever it is cut: no number is another, and what is missing is told, but where a row has just ended."""
    name, path = made
    [whole, *_] = FORMATS[name].read(path)
    file = next(path.iterdir()) if path.is_dir() else path
    data = file.read_bytes()
    silent = [-STRIDE]
    for end in range(0, len(data), STRIDE):
        file.write_bytes(data[:end])
        for log in read_or_refused(name, path)[:1]:
            assert len(log) < len(whole)
            for column in log.columns:
                is_known = ~np.isnan(log[column])
                assert is_known.all() or column == "since"
                assert log[column][is_known].tolist() == whole[column][: len(log)][is_known].tolist()
            if not any("left out" in note for note in log.facts.notes):
                assert end > silent[-1] + STRIDE
                silent.append(end)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")
@pytest.mark.parametrize("name", FOREIGN)
def test_a_pipe_that_nobody_writes_to_holds_nobody_up(tmp_path, name):
    """Whatever it is called."""
    path = tmp_path / "events.out.tfevents.1.csv"
    os.mkfifo(path)
    assert not read_or_refused(name, path)


def test_bytes_that_mean_nothing_raise_our_own_errors_alone(made):
    """Some of an example's bytes are others; what is still read is finite."""
    name, path = made
    file = next(path.iterdir()) if path.is_dir() else path
    example = file.read_bytes()
    for seed in range(40):
        generator = np.random.default_rng(seed)
        data = bytearray(example)
        for place in generator.integers(0, len(data), 1 + seed // 2):
            data[place] = int(generator.integers(0, 256))
        file.write_bytes(bytes(data))
        assert FORMATS[name].recognises(path, bytes(data[:4096])) in (True, False)
        for log in read_or_refused(name, path):
            assert all(np.isfinite(log[column]).all() for column in log.columns if column not in ("seconds", "since"))
