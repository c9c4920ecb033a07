"""Whatever a file says: a reader answers within a second, in little memory, and touches nothing."""

import os
import sys
import time
import tracemalloc
from contextlib import contextmanager
from random import Random

import pytest

from harness import load_registry
from harness.errors import HarnessError
from harness.executor import Cell
from harness.registry import choose
from tests.fuzz.readers import readers

KINDS = {"simulators": "ideal", "tasks": "fd100-reach", "algorithms": "wander", "rewards": "arp"}
SECONDS, BYTES = 1.0, 500_000_000
MEASURED = 50
"""Of so many inputs the memory of one is measured, which takes ten times as long."""
WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND
TOUCHES = ("os.remove", "os.rename", "os.mkdir", "os.rmdir", "os.link", "os.symlink", "os.chmod", "os.truncate",
           "subprocess.Popen", "socket.connect", "os.system", "shutil.rmtree", "pickle.find_class")  # fmt: skip


class Watch:
    """What is done to files while a reader reads; python tells every hook of it."""

    def __init__(self) -> None:
        self.is_on = False
        self.touched: list[str] = []

    def __call__(self, event, args):
        """As an audit hook is called."""
        if not self.is_on:
            return
        if (
            event == "open" and isinstance(args[2], int) and args[2] & WRITING and args[0] != os.devnull
        ) or event in TOUCHES:
            self.touched.append(f"{event} {args}")


WATCH = Watch()


@pytest.fixture(scope="session")
def fuzz(tmp_path_factory):
    """Let a reader read what a seed makes of its files; tells whether it was refused."""
    sys.addaudithook(WATCH)
    folder = tmp_path_factory.mktemp("fuzz")

    def read(reader, seed):
        rng = Random(seed)
        for name, content in reader.files.items():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_bytes(content)
        name = rng.choice(list(reader.mutate))
        (folder / name).write_bytes(reader.mutate[name](reader.files[name], rng))
        with _bounded(seed % MEASURED == 0):
            try:
                reader.read(folder)
            except HarnessError:
                return True
            return False

    return read


@pytest.fixture(scope="session")
def all_readers(toy_folder, tmp_path_factory):
    """Every reader by name, with the plugins and the toys."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(toy_folder)
        patch.delenv("HARNESS_PLUGINS", raising=False)
        registry = load_registry()
        simulator, task, algorithm, reward = [choose(registry, kind, name) for kind, name in KINDS.items()]
        cell = Cell(simulator, "fd100", task, algorithm, reward, 0, 12, 2)
        yield readers(registry, cell, tmp_path_factory.mktemp("examples"))


@contextmanager
def _bounded(is_measured):
    """Raises AssertionError if the block takes too long, too much, or touches a file."""
    WATCH.touched.clear()
    if is_measured:
        tracemalloc.start()
    WATCH.is_on, start = True, time.process_time()
    try:
        yield
    finally:
        seconds, WATCH.is_on = time.process_time() - start, False
        peak = tracemalloc.get_traced_memory()[1] if is_measured else 0
        tracemalloc.stop()
    assert not WATCH.touched
    assert is_measured or seconds <= SECONDS  # tracemalloc slows everything down
    assert peak <= BYTES
