"""What holds for all registered formats of logs."""

from pathlib import Path

import numpy as np
import pytest

from harness.errors import HarnessError
from harness.log import Log
from harness.log.format import HEAD
from harness.log.open_log import formats_of, open_logs
from harness.registry.registry import load_registry

REGISTRY = load_registry()
FORMATS = formats_of(REGISTRY)
STRIDE = 7
"""Bytes from one cut to the next; rows are longer."""
FOREIGN = ("monitor", "evaluations", "tensorboard", "tensorboard-csv", "progress-csv", "wandb-csv", "episode-csv")


@pytest.mark.parametrize("name", FOREIGN)
def test_an_example_is_recognised_by_its_own_format_alone(tmp_path: Path, name: str):
    """Nobody has to say what it is."""
    path = FORMATS[name].write_example(tmp_path)
    head = path.read_bytes()[:HEAD] if path.is_file() else b""
    assert [other for other, it in FORMATS.items() if it.recognises(path, head)] == [name]


@pytest.mark.parametrize("name", FOREIGN)
def test_an_example_has_returns_or_success_in_every_row(tmp_path: Path, name: str):
    """Through the door that all logs come in by, with finite numbers."""
    for log in open_logs(FORMATS[name].write_example(tmp_path), REGISTRY):
        assert len(log) > 1
        assert "reward/recorded" in log
        assert all(np.isfinite(log[column]).all() for column in log.columns)
        assert log.facts.unit in ("episode", "point")


def read_or_refused(name: str, path: Path) -> tuple[Log, ...]:
    """The logs of a damaged file; none if it is refused, in one line that names it."""
    try:
        return tuple(FORMATS[name].read(path))
    except HarnessError as error:
        sentence = str(error)
    assert str(path) in sentence
    assert "\n" not in sentence
    return ()


@pytest.mark.parametrize("name", FOREIGN)
def test_a_cut_file_is_refused_or_has_the_first_rows(tmp_path: Path, name: str):
    """Wherever it is cut: no number is another, and what is missing is told, but where a row has just ended."""
    path = FORMATS[name].write_example(tmp_path)
    [whole, *_] = FORMATS[name].read(path)
    file = next(path.iterdir()) if path.is_dir() else path
    data = file.read_bytes()
    silent = [-STRIDE]
    for end in range(0, len(data), STRIDE):
        file.write_bytes(data[:end])
        for log in read_or_refused(name, path)[:1]:
            assert len(log) < len(whole)
            assert all(log[column].tolist() == whole[column].tolist()[: len(log)] for column in log.columns)
            if not any("left out" in note for note in log.facts.notes):
                assert end > silent[-1] + STRIDE
                silent.append(end)


@pytest.mark.parametrize("name", FOREIGN)
def test_bytes_that_mean_nothing_raise_our_own_errors_alone(tmp_path: Path, name: str):
    """Some of an example's bytes are others; what is still read is finite."""
    path = FORMATS[name].write_example(tmp_path)
    file = next(path.iterdir()) if path.is_dir() else path
    example = file.read_bytes()
    for seed in range(40):
        generator = np.random.default_rng(seed)
        data = bytearray(example)
        for place in generator.integers(0, len(data), 1 + seed // 2):
            data[place] = int(generator.integers(0, 256))
        file.write_bytes(bytes(data))
        assert FORMATS[name].recognises(path, bytes(data[:HEAD])) in (True, False)
        for log in read_or_refused(name, path):
            assert all(np.isfinite(log[column]).all() for column in log.columns if column != "seconds")
