"""How long and how much memory `harness eta` takes on files of the published size, and of any size."""

import json
import shutil
import subprocess
import sys
import time
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

ROWS, RUNS = 55_000, 10
HEADER = (
    "t,beginDistance,prevBest,distance,delta_distance,reward,target x,target y,target z,endEff x ,endEff y ,endEff z \n"
)
MEASURE = """
import json, resource, subprocess, sys
done = subprocess.run(sys.argv[1:], capture_output=True, text=True)
peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
print(json.dumps({"status": done.returncode, "out": done.stdout, "err": done.stderr, "peak": peak}))
"""


class Measured(NamedTuple):
    """One call of the command."""

    data: dict[str, Any]
    seconds: float
    megabytes: float


def measure(*arguments: object) -> Measured:
    """Call `harness eta --json` in a process of its own; its peak memory is that of no other process."""
    command = shutil.which("harness", path=str(Path(sys.executable).parent))
    assert command is not None
    call = [sys.executable, "-c", MEASURE, command, "eta", *map(str, arguments), "--json"]
    started = time.perf_counter()
    answer = json.loads(subprocess.run(call, check=True, capture_output=True, text=True).stdout)
    seconds = time.perf_counter() - started
    assert answer["status"] == 0, answer["err"]
    return Measured(json.loads(answer["out"]), seconds, answer["peak"] / 1024)


def write_run(path: Path, seed: int, k2: float, rows: int = ROWS) -> None:
    """A file as the K2 program writes them, or, with k2 = 1, as the base line does; five equal steps per decision."""
    rng = np.random.default_rng(seed)
    begin, target = 1.110047, "0.45,0.2,0.45,-0.1857659,1.049303,0.1233658"
    progress = np.linspace(0.0, 1.0, rows // 5)
    decided = np.repeat(rng.uniform(0.05, 1.6 - 0.7 * progress), 5)
    lines, step, best = [HEADER], 0, begin
    for distance in decided.tolist():
        before, far = best, begin if step == 0 else distance
        delta = far - before
        best = min(before, far)
        reward = 0.0 if step == 0 else -delta if delta > 0 else k2 * (begin - far)
        if k2 == 1.0:
            told = f",{begin},{before:.7g},{far:.7g},{'' if step else 0},{reward:.7g},{target}\n"
        else:
            told = f"{step},{begin},{best:.7g},{far:.7g},{delta:.7g},{reward:.7g},{target}\n"
        lines.append(told)
        step = 0 if step == 27 else step + 1
        best = begin if step == 0 else best
    path.parent.mkdir(exist_ok=True)
    path.write_text("".join(lines))


@pytest.mark.bench
def test_twenty_files_of_the_published_size_take_three_seconds(tmp_path: Path):
    """Ten base-line files and ten K2 files of 55,000 rows, rewards found out and both etas split: 3 s, 500 MB."""
    for seed in range(RUNS):
        write_run(tmp_path / "base" / f"{seed}.csv", seed, 1.0)
        write_run(tmp_path / "k2" / f"{seed}.csv", 50 + seed, 1.5)
    patterns = ("--baseline", tmp_path / "base" / "*.csv", "--proposed", tmp_path / "k2" / "*.csv")
    calls = [measure(*patterns) for _ in range(3)]
    seconds = sorted(call.seconds for call in calls)
    print(f"\n  harness eta: {seconds} s, {calls[0].megabytes:.0f} MB")  # noqa: T201
    assert calls[0].data["rewards"] == {"baseline": "baseline", "proposed": "arp:k1=1,k2=1.5"}
    assert calls[0].data["baseline"]["steps"] == ROWS
    assert calls[0].data["ruler_p"]["value"] is not None
    assert seconds[1] < 3.0
    assert max(call.megabytes for call in calls) < 500.0


@pytest.mark.slow
def test_ten_million_rows_take_no_more_memory(tmp_path: Path):
    """A file of 1e7 rows beside a short one: the same 500 MB."""
    write_run(tmp_path / "short.csv", 0, 1.5, 100_000)
    lines = (tmp_path / "short.csv").read_text()
    rows = lines.removeprefix(HEADER)
    with (tmp_path / "long.csv").open("w") as file:
        file.write(HEADER)
        for _ in range(100):
            file.write(rows)
    call = measure("--baseline", tmp_path / "long.csv", "--proposed", tmp_path / "long.csv")
    print(f"\n  1e7 rows, twice: {call.seconds:.1f} s, {call.megabytes:.0f} MB")  # noqa: T201
    assert call.data["baseline"]["steps"] == 10_000_000
    assert call.data["eta_n"]["value"] == 1.0
    assert call.megabytes < 500.0
