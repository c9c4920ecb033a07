"""Another process reads what a library may never finish reading, or not in bounded memory."""

import json
import os
import signal
import subprocess
import sys
import tempfile
from contextlib import suppress
from importlib import import_module
from typing import Any

from harness.errors import UsageError

CPU_SECONDS = 60
"""What it may compute, [s]: the largest public arms with their meshes take some five."""
MEMORY = 2**31
"""The most bytes of its data."""
WAIT = 600.0
"""How long it may take on a busy machine, or while it waits for something, [s]."""
CHILD = "from harness.files.apart import answer; answer()"


def run_apart(module: str, function: str, *words: str, cpu_seconds: int = CPU_SECONDS, memory: int = MEMORY) -> Any:
    """What a function says of some words, called in a process of bounded time and memory.

    Windows bounds neither; there a process ends after `WAIT` alone.

    Args:
        module: Of the function.
        function: Takes `words`, returns what JSON has, and raises `UsageError`.
        words: For it.
        cpu_seconds: It may compute so long, [s].
        memory: It may have so many bytes of data.

    Raises:
        UsageError: The function raised it, or its process was ended.
        RuntimeError: It raised something else.
    """
    known = os.pathsep.join(path for path in sys.path if path)
    surroundings = {**os.environ, "PYTHONPATH": known, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    command = [sys.executable, "-P", "-c", CHILD, str(cpu_seconds), str(memory), module, function, *words]
    with tempfile.TemporaryDirectory() as folder:  # engines leave logs where they stand
        try:
            done = subprocess.run(
                command, capture_output=True, cwd=folder, env=surroundings, timeout=WAIT, check=False, text=True
            )
        except subprocess.TimeoutExpired as error:
            raise UsageError(f"reading it took more than {WAIT:g} s") from error
    if done.returncode > 0:
        raise RuntimeError(done.stderr.rstrip().rpartition("\n")[2])
    if done.returncode:
        if (ended := signal.Signals(-done.returncode).name) in {"SIGXCPU", "SIGKILL"}:
            raise UsageError(f"reading it takes more than {cpu_seconds} s of computing")
        needs = f"it is damaged, or needs more than {memory / 2**30:.2g} GiB of memory"
        raise UsageError(f"what reads it ended by {ended}: {needs}")
    told = json.loads(done.stdout)
    if "refused" in told:
        raise UsageError(told["refused"])
    return told["told"]


def answer() -> None:
    """Call what the command line names, and write what it says; for the process that `run_apart` starts."""
    seconds, memory, module, function, *words = sys.argv[1:]
    with suppress(ImportError):  # Windows
        import resource

        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        resource.setrlimit(resource.RLIMIT_CPU, (int(seconds), int(seconds) + 1))
        resource.setrlimit(resource.RLIMIT_DATA, (int(memory), int(memory)))
    out = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)  # what engines print is no answer
    try:
        said = {"told": getattr(import_module(module), function)(*words)}
    except UsageError as error:
        said = {"refused": str(error)}
    except MemoryError:
        said = {"refused": f"it needs more than {int(memory) / 2**30:.2g} GiB of memory"}
    with out:
        json.dump(said, out)
