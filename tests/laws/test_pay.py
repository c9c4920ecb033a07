"""What a reward pays is finite and within 1e150, at every door; of any other number the door says so."""

import re
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pyarrow.parquet as pq
import pytest

import harness
from harness import load_registry
from harness.errors import HarnessError
from harness.experiment.environments.paid_again import PayAgain
from harness.log import LogFacts, in_memory
from harness.log.text_table import parse_table
from harness.payoff.dataset.paid_dataset import pay_dataset
from harness.payoff.dataset.rewards import Recorded, given_rewards
from harness.payoff.rollout import record_rollouts, score_rollout
from harness.record import read_trace
from harness.record.folder import SCORES
from harness.registry import choose, read_given
from harness.reward.forms import reward_class
from harness.score.compare import compare_logs
from harness.score.installed_reward import InstalledReward
from harness.score.open_steps import open_steps
from harness.score.rescore import rescore
from harness.task import ReachTask
from harness_plugins.audit import audit_rewards
from harness_plugins.audit.search.place import places_in_environment, places_on_task, world_at
from harness_plugins.kit import IdealSimulator
from tests.laws.test_ends import DOORS as TRACED, PLACES, SHORT, data_set, traced
from tests.registered import FD100

LARGEST = 1e150
PLAIN = {"the largest": LARGEST, "the smallest": -LARGEST, "nothing": 0.0}
ODD = {
    "too large": 1e200, "too small": -1e200, "a little too large": 1.000001 * LARGEST, "infinite": np.inf,
    "no number": np.nan,
}  # fmt: skip
CODE = "from numpy import inf, nan\n\ndef odd(step):\n    return {} + 0.0 * getattr(step, 'distance', 0.0)\n"
CARTS = "CartPole-v1"


@dataclass
class Paying:
    """A reward that pays this number for any step, in a folder that is empty."""

    number: float
    folder: Path

    def function(self, step):
        """It in an environment."""
        return self.number

    @property
    def of_arm(self):
        """It as a reward of an arm."""
        return reward_class(lambda step: self.number + 0.0 * step.distance)()

    @property
    def registry(self):
        """It as a file, beside the plugins."""
        (self.folder / "odd.py").write_text(CODE.format(self.number))
        return load_registry(given=read_given([self.folder / "odd.py"]))

    @property
    def choice(self):
        """It by its name."""
        return choose(self.registry, "rewards", "odd")

    @property
    def plain(self):
        """The folder, as left by one that pays nothing."""
        return Paying(0.0, self.folder)


def trace_of(it):
    """What an arm recorded that was paid by it."""
    return traced(SHORT, *TRACED["training"], it.folder / "trace.parquet", it.of_arm)


def trace(it):
    """An arm trains."""
    trace_of(it)


def changed_trace(it):
    """Somebody changed a number of a trace."""
    trace_of(it.plain)
    path = it.folder / "trace.parquet"
    table = pq.read_table(path)
    paid = np.where(np.arange(len(table)) == 3, it.number, table["reward"].to_numpy())
    at = table.column_names.index("reward")
    pq.write_table(table.set_column(at, table.field("reward"), [paid]), path)
    read_trace(path).load()


def script(it):
    """Scripts move an arm."""
    score_rollout(it.of_arm, record_rollouts(IdealSimulator(), FD100, ReachTask(horizon=5), 2)[0])


def installed(it):
    """A trace is paid by a reward of the experiment."""
    InstalledReward(it.choice, it.registry).pay(trace_of(it.plain), None)


def rescored(it):
    """The same, into a file beside it."""
    trace_of(it.plain)
    return rescore(read_trace(it.folder / "trace.parquet"), [it.choice], it.folder / SCORES, it.registry).get("odd")


def data_set_by_function(it):
    """A function pays a data set."""
    return pay_dataset(data_set(), given_rewards({"odd": it.function}, None)).failed.get("odd")


def data_set_by_arm(it):
    """A reward of an arm pays a data set."""
    return pay_dataset(data_set(), given_rewards({"odd": it.of_arm}, PLACES)).failed.get("odd")


def data_set_itself(it):
    """A data set tells what was paid."""
    rows = data_set().rows().columns
    paid = {"reward/recorded": np.full(len(rows["step"]), it.number)}
    return pay_dataset(
        in_memory(LogFacts(path=Path("x"), format="set"), rows | paid), {"odd": Recorded("recorded")}
    ).failed.get("odd")


def recorded(it):
    """A recorder is at an environment."""
    rewards = {"own": "own", "odd": it.function}
    with harness.RecordRewards(
        gymnasium.make(CARTS), it.folder / "one", trained_with="own", rewards=rewards, on_error="raise"
    ) as env:
        env.reset(seed=0)
        env.step(0)


def recorded_in_batch(it):
    """It is at a batch of environments."""
    envs, rewards = gymnasium.make_vec(CARTS, num_envs=2), {"own": "own", "odd": it.function}
    with closing(
        harness.RecordVectorRewards(envs, it.folder / "one", trained_with="own", rewards=rewards, on_error="raise")
    ) as env:
        env.reset(seed=0)
        env.step(np.zeros(2, int))


def recorded_of_env(it):
    """The environment itself pays it."""
    paying = gymnasium.wrappers.TransformReward(gymnasium.make(CARTS), lambda paid: it.number)
    with harness.RecordRewards(
        paying, it.folder / "one", trained_with="own", rewards={"own": "own"}, on_error="raise"
    ) as env:
        env.reset(seed=0)
        env.step(0)


def paid_again(it):
    """A recording is paid by a reward that was written later."""
    recorded(it.plain)
    (paid,) = PayAgain(it.registry, ["odd"]).run(it.folder / "one")
    return " ".join((*paid.failed, paid.refused))


def audited(it):
    """An audit sets rewards beside one another."""
    audit_rewards(CARTS, {"odd": it.function}, episodes=1, steps=5)


def searched(it):
    """A search plays in an environment."""
    task = choose(it.registry, "environments", {"name": "gymnasium", "id": CARTS})
    (place,) = places_in_environment(it.registry, task, ["odd"], 0.9)
    with closing(world_at(place, it.registry)) as world:
        world.at_random(range(3))


def searched_of_arm(it):
    """A search plays an arm's task."""
    (place,) = places_on_task(it.registry, [it.choice], SHORT, None, None, 0.95)
    with closing(world_at(place, it.registry)) as world:
        world.at_random(range(3))


def log(it):
    """A format of anybody makes a log."""
    in_memory(LogFacts(path=Path("x"), format="of a test"), {"reward/odd": np.array([0.0, it.number])})


def table(it):
    """A program wrote a table."""
    parse_table(Path("x"), f"r\n0\n{it.number}\n").numbers("r")


def steps(it):
    """A program wrote a step a row."""
    path = it.folder / "steps.csv"
    path.write_text(f"reward\n0\n{it.number}\n0\n")
    compare_logs([open_steps(path)], [open_steps(path)], load_registry())


ONE, ANY = r"no number within 1e\+150", r"a number that is not finite, or beyond 1e\+150"
DOORS: dict[Any, str] = {
    trace: rf"^reward is .*{ONE}|^pay was (infinite|NaN) at step 1",
    changed_trace: f"reward holds {ANY}",
    script: f"the reward pays 'finish' .*{ONE}, at step 1",
    installed: f"reward odd pays {ANY}",
    rescored: f"reward odd pays {ANY}",
    data_set_by_function: f"episode 0: ValueError: it pays {ANY}",
    data_set_by_arm: f"episode 0: ValueError: it pays {ANY}",
    data_set_itself: f"it pays {ANY}|a value of reward/recorded is .* beyond all returns",
    recorded: f"'odd' failed in .* step 0: ValueError: it is .*{ONE}",
    recorded_in_batch: f"'odd' failed in .* step 0: ValueError: it is .*{ONE}",
    recorded_of_env: f"'own' failed in .* step 0: ValueError: it is .*{ONE}|pay was (infinite|NaN) at step 1",
    paid_again: f"odd fails in .* step 0: ValueError: it is .*{ONE}",
    audited: f"'odd' failed in .* step 0: ValueError: it is .*{ONE}",
    searched: f"'odd' failed in .* step 1: ValueError: it is .*{ONE}|the reward pays {ANY}, in the episode of start 0",
    searched_of_arm: rf"the reward pays {ANY}, in the episode of start 0|pay was (infinite|NaN) at step 1",
    log: "a value of reward/odd is .* beyond all returns",
    table: "line 3: column 'r' holds .*no number that can be read",
    steps: "line 3, column 'reward': '.*' is no finite number|is missing: it is paid no number",
}
"""By door, what it says."""
UNKNOWN = (log,)
"""Doors at which no number stands for what is not known."""


@pytest.mark.parametrize("door", DOORS)
def test_a_number_that_cannot_be_counted_with_is_told(door, tmp_path, subtests):
    """And no other, up to the largest; nobody reads 200 digits."""
    for name, number in {**PLAIN, **ODD}.items():
        with subtests.test(name):
            (folder := tmp_path / name).mkdir()
            try:
                told = door(Paying(number, folder))
            except (HarnessError, UserWarning) as error:
                told = str(error)
            if name in PLAIN or (name == "no number" and door in UNKNOWN):
                assert not told
            else:
                assert re.search(DOORS[door], told or "")
                assert not re.search(r"\d{100}", told)


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize("door", DOORS)
def test_every_door_asks_the_one_law(door, tmp_path, monkeypatch):
    """The mutant: without a largest number no door says anything of a finite one."""
    monkeypatch.setattr("harness.log.log.LARGEST", np.inf)
    assert not door(Paying(1e200, tmp_path))
