"""D4RL's files become logs of steps, or are refused where nothing says which step belongs to which episode.

The layout is that of https://github.com/Farama-Foundation/D4RL/wiki: arrays of one row for each step, of all episodes.
"""

import h5py
import numpy as np
import pytest

from harness.errors import SchemaError, UsageError
from harness_plugins.audit import audit_dataset
from tests.record.dataset.written import opened

LENGTHS = (3, 1, 4)
STEPS = sum(LENGTHS)
ENDS = np.cumsum(LENGTHS) - 1
TERMINALS = np.isin(np.arange(STEPS), ENDS[:1])
TIMEOUTS = np.isin(np.arange(STEPS), ENDS[1:])


def write(path, **arrays):
    """A file of three episodes; the first one ends, the others are cut. None leaves an array out."""
    rng = np.random.default_rng(0)
    told = {
        "observations": rng.normal(size=(STEPS, 3)).astype(np.float32),
        "actions": rng.normal(size=(STEPS, 2)).astype(np.float32),
        "rewards": np.arange(STEPS, dtype=np.float32),
        "terminals": TERMINALS,
        "timeouts": TIMEOUTS,
        "infos/qpos": rng.normal(size=(STEPS, 4)),
        "infos/success": np.arange(STEPS) == 2,
        "infos/action_log_std": np.zeros(2),
        "metadata/algorithm": np.bytes_("SAC"),
        **arrays,
    }
    with h5py.File(path, "w") as file:
        for key, values in told.items():
            if values is not None:
                file[key] = values
    return f"d4rl:{path}"


def stored(text, key):
    """What stands in the file."""
    with h5py.File(text.removeprefix("d4rl:"), "r") as file:
        return np.asarray(file[key])


def read(text, **settings):
    """All columns of the log."""
    return opened(text, **settings).rows()


def test_episodes_end_where_the_flags_say(tmp_path):
    """By terminals and by timeouts; steps are counted in each."""
    rows = read(write(tmp_path / "d.hdf5"))
    assert rows["episode"].tolist() == [0, 0, 0, 1, 2, 2, 2, 2]
    assert rows["step"].tolist() == [1, 2, 3, 1, 1, 2, 3, 4]
    assert np.flatnonzero(rows["terminated"]).tolist() == [2]
    assert np.flatnonzero(rows["truncated"]).tolist() == [3, 7]


def test_a_step_holds_what_was_seen_before_and_after_it(tmp_path):
    """After the last step of an episode nothing is known: the row behind it belongs to another one."""
    text = write(tmp_path / "d.hdf5")
    rows, seen = read(text), stored(text, "observations")
    last = np.isin(np.arange(STEPS), ENDS)
    assert np.array_equal(rows["before/observation"], seen)
    assert np.array_equal(rows["observation"][~last], seen[1:][~last[:-1]])
    assert np.isnan(rows["observation"][last]).all()
    assert rows["seen"].tolist() == (~last).tolist()
    assert rows["reward/recorded"].tolist() == list(range(STEPS))
    assert np.array_equal(rows["info/qpos"], stored(text, "infos/qpos"))


def followed(tmp_path, last=1.0):
    """What was seen after each step; after the last one of an episode 7, as no row behind it tells."""
    seen = stored(write(tmp_path / "a.hdf5"), "observations")
    after = np.concatenate([seen[1:], np.full((1, 3), last, np.float32)])
    after[ENDS if last == 1.0 else ENDS[:-1]] = 7.0
    return after


def test_next_observations_are_what_was_seen_after_each_step(tmp_path):
    """Also after the last one of an episode, of which no row behind it tells."""
    after = followed(tmp_path)
    log = opened(write(tmp_path / "d.hdf5", next_observations=after))
    assert np.array_equal(log["observation"], after)
    assert "seen" not in log


def test_a_horizon_says_where_episodes_were_cut(tmp_path):
    """Counted anew behind each that ended by itself, as D4RL's own reader does."""
    text = write(tmp_path / "d.hdf5", timeouts=None).replace("d4rl:", "d4rl:horizon=2:")
    rows = read(text)
    assert rows["episode"].tolist() == [0, 0, 1, 2, 2, 3, 3]
    assert np.flatnonzero(rows["truncated"]).tolist() == [1, 4, 6]


def test_without_timeouts_next_observations_say_where_episodes_end(tmp_path):
    """Where the row behind does not begin with what was seen."""
    after = followed(tmp_path)
    rows = read(write(tmp_path / "d.hdf5", timeouts=None, next_observations=after))
    assert rows["episode"].tolist() == [0, 0, 0, 1, 2, 2, 2, 2]


@pytest.mark.parametrize("shows", [False, True])
def test_steps_of_an_episode_that_does_not_end_are_left_out(tmp_path, shows):
    """And told: their return is not that of a whole episode.

    Also where next observations show what was seen: no row behind the last step does, as where a file has a million
    steps and no more.
    """
    after = followed(tmp_path, 9.0) if shows else None
    log = opened(write(tmp_path / "d.hdf5", timeouts=np.arange(STEPS) == 3, next_observations=after))
    assert len(log) == 4
    assert "Left out, since no row ends the episode: the last 4 steps" in log.facts.notes


def test_terminals_that_stay_true_are_told(tmp_path):
    """As antmaze has them, while the ant goes on."""
    log = opened(write(tmp_path / "d.hdf5", terminals=np.arange(STEPS) > 1))
    assert any("Episodes of a single step" in note and note.endswith(": 5") for note in log.facts.notes)


def test_a_reward_that_needs_the_last_observation_is_not_paid_there(tmp_path):
    """An episode of one step has one observation, and no other stands in for the second: d3rlpy 98."""
    found = audit_dataset(write(tmp_path / "d.hdf5"), {"after": lambda step: float(step.observation[0])})
    (reward,) = found.rewards
    assert any(line.startswith("not paid the last step of 2 episodes") for line in reward.unpaid)
    assert any(line.endswith("1 episodes (the first is 1)") for line in reward.unpaid)


def test_success_stands_in_infos(tmp_path):
    """Found by its name, and by a threshold."""
    text = write(tmp_path / "d.hdf5", **{"infos/near": np.linspace(0.0, 1.0, STEPS)})
    assert read(text)["behaviour/success"].tolist() == [0.0, 0.0, 1.0] + [0.0] * 5
    assert read(text, success="near>0.5")["behaviour/success"].tolist() == [0.0] * 4 + [1.0] * 4
    with pytest.raises(UsageError, match=r"--success won: .* It has"):
        opened(text, success="won")


def test_the_audit_ranks_as_a_computation_of_returns_does(tmp_path):
    """By file alone, without its format: 20 episodes of 5 steps, of which every second one succeeds."""
    rng = np.random.default_rng(1)
    pay = rng.normal(size=100) + np.repeat(np.arange(20) % 2, 5) * 0.5
    flags = np.arange(100) % 5 == 4
    won = flags & (np.arange(100) // 5 % 2 == 1)
    told = {"observations": rng.normal(size=(100, 3)), "actions": rng.normal(size=(100, 2)), "rewards": pay}
    write(
        tmp_path / "d.hdf5", **told, terminals=np.zeros(100, bool), timeouts=flags,
        **{"infos/qpos": None, "infos/success": won},
    )  # fmt: skip
    found = audit_dataset(str(tmp_path / "d.hdf5"))
    returns = pay.reshape(20, 5).sum(axis=1)
    expected = np.mean(returns[1::2][:, None] > returns[::2])
    assert (found.successes, found.failures) == (10, 10)
    assert found.rewards[0].by_success.value == pytest.approx(expected)


SHORT = np.zeros(STEPS - 1)


@pytest.mark.parametrize(
    ("arrays", "horizon", "told"),
    [
        ({"rewards": SHORT}, "", r"rewards \d, terminals 8"),
        ({"observations": np.zeros((STEPS - 1, 3))}, "", r"rewards \d, terminals 8"),
        ({"terminals": np.full(STEPS, np.nan)}, "", "terminals holds nan in row 0"),
        ({"timeouts": np.arange(STEPS)}, "", "timeouts holds 2 in row 2"),
        (
            {"rewards": np.array([b"1"] * STEPS)},
            "",
            r"rewards holds no rows of at most 16,384 numbers, but \[8\] of \|S1",
        ),
        ({"next_observations": np.zeros((STEPS, 2))}, "", r"next_observations are \[8, 2\], and observations \[8, 3\]"),
        ({"timeouts": None}, "", r"has no timeouts.* d4rl:horizon=1000:FILE"),
        ({}, "horizon=2:", r"has timeouts, .* leave out horizon=2"),
        ({"timeouts": None}, "horizon=-2:", "horizon=-2: after at least 1 step"),
        (
            {"timeouts": None, "episode_terminals": TERMINALS | TIMEOUTS},
            "",
            "written by d3rlpy: it has episode_terminals",
        ),
    ],
)
def test_what_does_not_tell_its_episodes_is_refused(tmp_path, arrays, horizon, told):
    """By its array, or by what is given beside it.

    An episode that was cut would go on in the next one (D4RL 137). Rewards of d3rlpy stand a row later in some
    versions, and its episodes lack their last observation (d3rlpy 98).
    """
    with pytest.raises((SchemaError, UsageError), match=told):
        opened(write(tmp_path / "d.hdf5", **arrays).replace("d4rl:", f"d4rl:{horizon}"))


def test_flags_in_the_wrong_rows_are_refused(tmp_path):
    """The observation behind a step is not what was seen after it, and no flag says so: D4RL 137."""
    moved = np.isin(np.arange(STEPS), [4, 7])
    with pytest.raises(SchemaError, match=r"row 3 ends no episode .* the flags stand in the wrong rows"):
        opened(write(tmp_path / "d.hdf5", timeouts=moved, next_observations=followed(tmp_path)))


def test_more_steps_than_are_held_are_refused_unread(tmp_path):
    """A file may declare them without a byte of them."""
    text = write(tmp_path / "d.hdf5")
    with h5py.File(tmp_path / "d.hdf5", "a") as file:
        for key in ("observations", "actions", "rewards", "terminals", "timeouts"):
            del file[key]
            file.create_dataset(key, (90_000_000,), "f8", chunks=(1000,))
    with pytest.raises(SchemaError, match="90,000,000 steps, 20,000,000 are allowed"):
        opened(text)
