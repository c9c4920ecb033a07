"""What it costs to pay a data set, beside a loop over the same arrays that h5py reads."""

import json
import sys

import h5py
import numpy as np
import pytest

from harness.payoff.dataset.paid_dataset import pay_dataset
from harness.payoff.dataset.step_by_step import step_by_step
from tests.bench.timings.processes import measure
from tests.record.dataset.written import episode, opened, write_lerobot, write_minari
from tests.results.recordings.conftest import PULLS, record

pytestmark = pytest.mark.bench
STEPS = 200


def _far(observation, action, next_observation, info):
    return -float(np.abs(next_observation).max())


def test_a_data_set_beside_a_bare_loop(tmp_path, require_speed, amount):
    """Reading in pieces, with every bound, what each episode is known by and how far each step moves, takes 2.2 times.

    All episodes are looked at before one is read, since what is declared is held against what is there.
    """
    count = amount(200, 3)
    folder = write_minari(tmp_path / "d", [episode(STEPS, number) for number in range(count)])
    paid = []

    def bare():
        paid.clear()
        with h5py.File(folder / "data" / "main_data.hdf5") as file:
            for number in range(count):
                group = file[f"episode_{number}"]
                observations, actions = group["observations"][:], group["actions"][:]
                success = group["infos/success"][1:]
                for row in range(STEPS):
                    info = {"success": success[row]}
                    paid.append(_far(observations[row], actions[row], observations[row + 1], info))

    def through_the_harness():
        assert pay_dataset(opened(f"minari:{folder}"), {"far": step_by_step("it", _far)}).paid["far"].tolist() == paid

    bare()
    require_speed(bare, through_the_harness, at_least=0.4, rounds=5)


@pytest.mark.parametrize("kind", ["minari", "lerobot"])
def test_a_million_steps(tmp_path, is_timed, amount, kind):
    """1,000 episodes of 1,000 steps take no more than 5 s of a core, and 0.4 GB."""
    count, steps = amount(1_000, 4), amount(1_000, 6)
    made = [dict(episode(steps, number, number % 2 == 1)) for number in range(count)]
    write = write_minari if kind == "minari" else write_lerobot
    folder = write(tmp_path / "d", made)
    taken = measure(sys.executable, "-m", "harness", "audit", f"{kind}:{folder}", "--json")
    told = json.loads(taken.out)
    assert (told["steps"], [it["reward"] for it in told["rewards"]]) == (count * steps, ["recorded"])
    print(f"\n  {kind}: {taken.cpu_seconds:.1f} s, {taken.megabytes:.0f} MB")  # noqa: T201
    assert not is_timed or (taken.cpu_seconds <= 5.0 and taken.megabytes <= 400.0)


def test_a_million_recorded_steps_with_two_rewards(tmp_path, is_timed, amount):
    """A recording of 200,000 episodes of 5 steps takes no more than the same, and reads what its rewards paid alone."""
    count = amount(200_000, 40)
    pays = {"plain": lambda arms: arms + 1.0, "square": lambda arms: (arms - 0.5) ** 2}
    record(tmp_path / "runs/0", "plain", 0, np.linspace(0.0, 0.9, count), pays=pays)
    taken = measure(sys.executable, "-m", "harness", "audit", str(tmp_path / "runs"), "--json")
    told = json.loads(taken.out)
    assert (told["rewards"], sum(row["episodes"] for row in told["earned"])) == (["plain", "square"], 2 * count // 5)
    assert told["pairs"][0]["steps"]["count"] == 1
    print(f"\n  {count * PULLS:,} steps: {taken.cpu_seconds:.1f} s, {taken.megabytes:.0f} MB")  # noqa: T201
    assert not is_timed or (taken.cpu_seconds <= 5.0 and taken.megabytes <= 400.0)
