"""What a process of its own takes: its CPU time and its peak memory, and those of no other process."""

import json
import subprocess
import sys
from typing import NamedTuple

MEASURE = """
import json, resource, subprocess, sys
done = subprocess.run(sys.argv[1:], capture_output=True, text=True)
used = resource.getrusage(resource.RUSAGE_CHILDREN)
cpu = used.ru_utime + used.ru_stime
print(json.dumps({"status": done.returncode, "out": done.stdout, "err": done.stderr, "cpu": cpu, "kb": used.ru_maxrss}))
"""
"""A small process between. The system counts the memory of whoever starts a process as its own until it begins."""


class Taken(NamedTuple):
    """What a command took, and what it printed."""

    out: str
    cpu_seconds: float
    megabytes: float


def measure(*command):
    """Run a command in a process of its own; it has to end with status 0."""
    call = [sys.executable, "-c", MEASURE, *map(str, command)]
    answer = json.loads(subprocess.run(call, check=True, capture_output=True, text=True).stdout)
    assert answer["status"] == 0, answer["err"]
    return Taken(answer["out"], answer["cpu"], answer["kb"] / 1024)
