"""What rows of other people's tables are: steps are read, and everything else is refused in one line."""

import numpy as np
import pytest

from harness.errors import UsageError
from harness.score.open_steps import open_steps
from tests.refusals import refused
from tests.registered import REGISTRY


def rewards_of(path):
    """What is read of a file."""
    return [
        value
        for piece in open_steps(path).pieces(["reward/recorded"], 3)
        for value in piece["reward/recorded"].tolist()
    ]


def write(path, header, rows):
    """A CSV file."""
    path.write_text("\n".join([header, *map(str, rows)]) + "\n")
    return path


def episodes(header):
    """Rows of ten episodes or iterations, by the columns of a header."""
    rng = np.random.default_rng(0)
    cell = {
        "episode": lambda number: number,
        "reward": lambda number: rng.normal(-19.0),
        "length": lambda number: 200,
        "l": lambda number: 150 + number,
        "t": lambda number: 0.5 * number,
        "": lambda number: number,
        "iteration": lambda number: number,
        "success": lambda number: number / 10,
    }
    return [",".join(str(cell[name](number)) for name in header.split(",")) for number in range(10)]


@pytest.mark.parametrize(
    ("header", "column"),
    [
        ("episode,reward,length", "length"),
        ("episode,reward", "episode"),
        (",episode,reward", "episode"),
        ("reward,l,t", "l"),
        ("reward,length", "length"),
        ("iteration,reward,success", "iteration"),
        ("reward,success", "success"),
    ],
)
def test_rows_that_are_episodes_are_refused(tmp_path, header, column):
    """The line says how it is known, what an index needs, and what to do if it is wrong."""
    path = write(tmp_path / "it.csv", header, episodes(header))
    with pytest.raises(UsageError) as raised:
        rewards_of(path)
    assert str(raised.value).startswith(f"{path}: its rows are episodes, or means over some (column '{column}')")
    assert "an index needs the reward of each environment step" in str(raised.value)
    assert "If each row is a step, delete the column" in str(raised.value)


@pytest.mark.parametrize("header", ['#{"t_start": 1.0, "env_id": "Pendulum-v1"}\nr,l,t'])
def test_a_log_of_another_program_is_called_by_name(tmp_path, header):
    """It has no reward of a step."""
    path = write(tmp_path / "it.csv", header, ["-19.8,200,0.0"])
    with refused("an index needs the reward of each environment step") as raised:
        open_steps(path, REGISTRY)
    assert str(raised.value).startswith(f"{path} is Monitor of stable-baselines3: a row is an episode, and")


STEPS = {
    "an episode that lasts": ("episode,reward", ["0,1", "0,2", "1,3", "1,4"]),
    "episodes of one step": ("episode,reward,length", ["0,1,1", "1,2,1", "2,3,1", "3,4,1"]),
    "episodes of one step, counted": ("episode,step,reward", ["0,0,1", "1,0,2", "2,0,3", "3,0,4"]),
    "a length beside each step": ("episode,reward,length", ["0,1,2", "0,2,2", "1,3,2", "1,4,2"]),
    "a length so far": ("reward,episode_length", ["1,1", "2,2", "3,1", "4,2"]),
    "a length in metres": ("reward,length", ["1,0.5", "2,0.5", "3,0.5", "4,0.5"]),
    "a time in seconds": ("t,reward", ["0,1", "0.02,2", "0.04,3", "0.06,4"]),
    "counted from 0 in each episode": ("t,reward", ["0,1", "1,2", "0,3", "1,4"]),
    "counted on and on": ("global_step,reward", ["7,1", "8,2", "9,3", "10,4"]),
    "pandas' index": (",reward", ["0,1", "1,2", "2,3", "3,4"]),
    "two envs": ("env,episode,step,reward", ["0,0,0,1", "1,1,0,2", "0,0,1,3", "1,1,1,4"]),
    "an episode called by letters": ("episode,reward", ["a,1", "b,2", "c,3", "d,4"]),
    "a column that is empty": ("episode,t,reward", [",,1", ",,2", ",,3", ",,4"]),
    "an episode that ended at once": ("t,reward", ["0,1", "0,2", "1,3", "2,4"]),
}


def test_rows_that_are_steps_are_read(tmp_path_factory, subtests):
    """Whatever else stands beside the reward."""
    for name, (header, rows) in STEPS.items():
        with subtests.test(name=name):
            tmp_path = tmp_path_factory.mktemp("case")
            assert rewards_of(write(tmp_path / "it.csv", header, rows)) == [1.0, 2.0, 3.0, 4.0]


LONG = [f"{number},{number % 7}" for number in range(300_000)]
"""Rows of a file of some megabytes, which comes in pieces."""


def test_a_count_that_is_no_count_of_steps_is_refused(tmp_path_factory, subtests):
    """Rows that are missing, stand twice or in another order: line, column and both numbers."""
    cases = [
        ("step,reward", ["0,1", "1000,2", "2000,3"], "line 3: column 'step' goes from 0 to 1,000: rows are missing"),
        ("t,reward", ["0,1", "1,2", "3,3"], "line 4: column 't' goes from 1 to 3: rows are missing"),
        ("t,reward", ["5,1", "6,2", "6,3"], "line 4: column 't' goes from 6 to 6: a row stands twice"),
        ("t,reward", ["5,1", "4,2"], "line 3: column 't' goes from 5 to 4: rows stand in another order"),
        (
            "global_step,reward",
            ["0,1", "1,2", "0,3"],
            "goes from 1 to 0: rows stand in another order, or the file holds",
        ),
        (",reward", ["0,1", "10,2"], "column 'without a name' goes from 0 to 10: rows are missing"),
        ("env,t,reward", ["0,0,1", "1,0,2", "0,1,3", "1,2,4"], "line 5: column 't' goes from 0 to 2"),
        ("step,reward", LONG[:250_000] + LONG[250_001:], "line 250002: column 'step' goes from 249,999 to 250,001"),
    ]
    for header, rows, told in cases:
        with subtests.test(header=header, rows=rows, told=told):
            tmp_path = tmp_path_factory.mktemp("case")
            with pytest.raises(UsageError) as raised:
                rewards_of(write(tmp_path / "it.csv", header, rows))
            assert told in str(raised.value)
            assert "delete that column" in str(raised.value)


@pytest.mark.parametrize(
    ("header", "rows", "told"),
    [
        *(
            (
                f"{run},step,reward",
                [f"{row // 4},{row % 4},0.5" for row in range(8)],
                f"line 6: column '{run.lower()}' goes from 0 to 1: the file holds several runs",
            )
            for run in ("seed", "run_id", "Trial", "exp_name")
        ),
        ("run,reward", ["ppo_a,1", "ppo_a,1", "ppo_b,1", "ppo_b,1"], "goes from ppo_a to ppo_b"),
        ("seed,episode,step,reward", [f"{row // 4},{row % 4 // 2},{row % 2},0.5" for row in range(8)], "several runs"),
        ("a,reward", ["1,2", "1,3", "a,reward", "1,4"], "line 4, column 'reward': the header stands here once more"),
    ],
)
def test_several_runs_in_one_file_are_refused(tmp_path, header, rows, told):
    """Their rewards would be added up as those of one run; the next run may count its episodes from 0 again."""
    with pytest.raises(UsageError) as raised:
        rewards_of(write(tmp_path / "a.csv", header, rows))
    assert told in str(raised.value)


@pytest.mark.parametrize(
    ("header", "rows"),
    [
        ("seed,step,reward", [f"7,{step},0.5" for step in range(8)]),
        ("episode,seed,step,reward", [f"{step // 4},{90 + step // 4},{step % 4},0.5" for step in range(8)]),
        ("step,reward", LONG),
        ("env,step,reward", [f"{env},{step},{step % 7}" for step in range(100_000) for env in range(3)]),
    ],
    ids=["a run", "episodes", "pieces", "envs in pieces"],
)
def test_the_seed_of_a_run_or_of_an_episode_is_read(tmp_path, header, rows):
    """One seed for all, or one that changes with the episode; counts of all or of each env go on across pieces."""
    assert rewards_of(write(tmp_path / "a.csv", header, rows)) == [float(row.rpartition(",")[2]) for row in rows]
