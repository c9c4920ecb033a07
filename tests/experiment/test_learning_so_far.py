"""What the last episodes of a training came to."""

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, strategies as st

from harness.experiment import world
from harness.experiment.arm_world import ArmWorld, LearningSoFar
from harness.experiment.environments.world import EnvironmentWorld
from harness.experiment.workers.order import TELL_EVERY
from harness.record import COLUMN, SCALARS
from harness.record.progress import LAST_EPISODES, RETURN, SPEED, SUCCESS


class Kept:
    """A recorder that keeps copies."""

    def __init__(self):
        self.rows = []

    def append(self, rows):
        """Keep a copy."""
        self.rows.append(rows.copy())


def rows_of(*told):
    """Rows as a trace has them, with two joints: (env, episode, step, paid, reached, ended) each."""
    rows = np.zeros((len(told), len(SCALARS) + 4))
    names = ("env", "episode", "step", "reward", "reached", "truncated")
    for row, values in zip(rows, told, strict=True):
        row[[COLUMN[name] for name in names]] = values
    return rows


def episode(number, length=3, paid=1.0, reached=False, env=0):
    """The rows of a whole episode, its start row included."""
    steps = [(env, number, step, paid, reached and step == length, step == length) for step in range(1, length + 1)]
    return rows_of((env, number, 0, 0.0, False, False), *steps)


def test_rows_are_handed_on():
    """All of them, as they are."""
    kept, rows = Kept(), episode(0)
    LearningSoFar(kept).append(rows)
    assert np.array_equal(kept.rows[0], rows)


def test_success_and_return_are_means_over_episodes():
    """Every payment counts, events too; an episode that is under way does not."""
    learning = LearningSoFar(Kept())
    rows = episode(0, reached=True)
    rows[-1, COLUMN["reward_target"]] = 1.0
    for part in (rows, episode(1, paid=-1.0), episode(2)[:-1]):
        learning.append(part)
    told = learning.means()
    assert told[SUCCESS] == 0.5
    assert told[RETURN] == pytest.approx((4.0 - 3.0) / 2)


def test_only_the_last_episodes_count():
    """What was learned long ago is forgotten."""
    learning = LearningSoFar(Kept())
    for number in range(2 * LAST_EPISODES):
        learning.append(episode(number, reached=number >= LAST_EPISODES))
    assert learning.means()[SUCCESS] == 1.0


def test_an_episode_whose_start_was_not_seen_is_left_out():
    """As when a killed training goes on in the middle of it: its return would lack what was paid before."""
    learning = LearningSoFar(Kept())
    learning.append(episode(7)[2:])
    assert SUCCESS not in learning.means()
    learning.append(episode(8))
    assert learning.means()[RETURN] == 3.0


@given(
    st.lists(st.tuples(st.integers(1, 5), st.booleans()), min_size=1, max_size=12),
    st.integers(1, 3),
    st.integers(1, 7),
    st.sampled_from([4, 16, 4096]),
)
def test_batches_and_blocks_do_not_matter(episodes, num_envs, chunk, block):
    """However the rows come, and however small the block: the result is that of all rows at once."""
    parts = [
        episode(number, length, paid=length, reached=reached, env=env)
        for number, (length, reached) in enumerate(episodes)
        for env in range(num_envs)
    ]
    rows = np.concatenate(parts)
    learning = LearningSoFar(Kept())
    learning.BLOCK = block
    for first in range(0, len(rows), chunk):
        learning.append(rows[first : first + chunk])
    told = learning.means()
    assert told[SUCCESS] == pytest.approx(np.mean([reached for _, reached in episodes]))
    assert told[RETURN] == pytest.approx(np.mean([length**2 for length, _ in episodes]))


def test_terms_are_told_by_name():
    """What each paid the last episodes on average; its columns end a row, behind those of the arm."""
    learning = LearningSoFar(Kept(), terms=("reach", "effort"))
    rows = np.concatenate([episode(0), episode(1)])
    columns = np.zeros((len(rows), 2))
    columns[1:4, 0], columns[5:8, 1] = 1.0, -0.5
    learning.append(np.hstack([rows, columns])[:6])
    learning.append(np.hstack([rows, columns])[6:])
    found = learning.means()
    assert (found["Reward Terms/reach"], found["Reward Terms/effort"]) == (1.5, -0.75)
    assert found[RETURN] == 3.0


def test_without_terms_there_are_no_names_of_them():
    """As of any reward that pays a number."""
    learning = LearningSoFar(Kept())
    learning.append(episode(0))
    assert not [name for name in learning.means() if name.startswith("Reward Terms")]


@pytest.mark.parametrize("kind", [ArmWorld, EnvironmentWorld])
def test_numbers_are_told_once_a_second(kind, tmp_path, monkeypatch):
    """Not at once, and not twice for the same steps; with the speed since they were told."""
    now = [100.0]
    monkeypatch.setattr(world, "time", SimpleNamespace(monotonic=lambda: now[0]))
    learning = kind(None, None, tmp_path, print)
    learning._last_episodes = lambda: {RETURN: 3.0}
    assert learning.learned(10, if_due=True) == {}
    now[0] += TELL_EVERY
    assert learning.learned(10, if_due=True) == {RETURN: 3.0, SPEED: pytest.approx(10 / TELL_EVERY)}
    assert learning.learned(20, if_due=True) == learning.learned(10) == {}
    assert learning.learned(20) == {RETURN: 3.0}
