"""From the logs of forty trainings to the answer: one command, less than ten seconds."""

import json
import sys
import time

import pytest
from numpy.random import default_rng

from tests.bench.timings.processes import measure

LONGEST = 10.0
"""From the command to its answer, [s]; 1.8 of Monitor files and 4 of event files were measured on two busy cores."""


def write_monitors(folder, seeds, episodes):
    """Files of two rewards as stable-baselines3's Monitor writes them."""
    rng = default_rng(0)
    for reward, share in (("base", 0.4), ("prop", 0.7)):
        for seed in range(seeds):
            rows = zip(rng.normal(size=episodes), rng.integers(20, 40, episodes), rng.random(episodes), strict=True)
            text = "".join(f"{pay:.6f},{length},1.5,{draw < share}\n" for pay, length, draw in rows)
            (folder / reward).mkdir(parents=True, exist_ok=True)
            head = json.dumps({"t_start": 1e9 + 1e4 * seed, "env_id": "Toy-v0"})
            (folder / reward / f"{seed}.monitor.csv").write_text(f"#{head}\nr,l,t,is_success\n{text}")


def write_events(folder, seeds, points):
    """Folders of two rewards with a file by TensorBoard's own writer in each."""
    pytest.importorskip("tensorboard", reason="needs the extra tensorboard")
    from tensorboard.compat.proto.event_pb2 import Event
    from tensorboard.compat.proto.summary_pb2 import Summary
    from tensorboard.summary.writer.record_writer import RecordWriter

    rng = default_rng(0)
    for reward, share in (("base", 0.4), ("prop", 0.7)):
        for seed in range(seeds):
            place = folder / f"{reward}_{seed}" / "PPO_1"
            place.mkdir(parents=True)
            with (place / "events.out.tfevents.1700000000.host").open("wb") as file:
                writer = RecordWriter(file)
                for step in range(1, points + 1):
                    told = {"rollout/ep_rew_mean": rng.normal(), "rollout/success_rate": share + rng.normal(0, 0.01)}
                    told["rollout/ep_len_mean"] = 9.0
                    values = [Summary.Value(tag=tag, simple_value=value) for tag, value in told.items()]
                    writer.write(Event(step=100 * step, summary=Summary(value=values)).SerializeToString())
                writer.flush()


@pytest.mark.bench
@pytest.mark.parametrize("write", [write_monitors, write_events])
def test_forty_logs_are_answered_at_once(tmp_path, amount, require_ratio, write):
    """A thousand rows each, sorted by their names and compared."""
    write(tmp_path, amount(20, 3), amount(1_000, 50))
    begin = time.perf_counter()
    taken = measure(sys.executable, "-c", "from harness.cli.app import main; main()", "report", tmp_path, "--json")
    wall = time.perf_counter() - begin
    (found,) = json.loads(taken.out)["combinations"]
    assert len(found["seeds"]) == amount(20, 3)
    require_ratio(LONGEST / wall, 1.0, f"({wall:.1f} s, {taken.cpu_seconds:.1f} s of CPU, {taken.megabytes:.0f} MB)")
