"""Tables of episodes as scripts of others write them; tables of steps are none."""

import csv

import gymnasium
import numpy as np
import pytest

from harness.errors import SchemaError, UsageError
from tests.plugins.logs.reading import Reader

ROWS = "0,-9.5,200\n1,-7.25,180\n2,-3.0,150\n"


read = Reader("table")
written = read.written


def test_episodes_of_gymnasiums_own_statistics_are_read(tmp_path):
    """A script's usual table: what RecordEpisodeStatistics tells at the end of each episode."""
    env = gymnasium.wrappers.RecordEpisodeStatistics(gymnasium.make("Pendulum-v1", max_episode_steps=7))
    rows = []
    for episode in range(5):
        env.reset(seed=episode)
        info = {}
        while "episode" not in info:
            *_, info = env.step(np.zeros(1, np.float32))
        rows.append((episode, float(info["episode"]["r"]), int(info["episode"]["l"])))
    with (tmp_path / "0.csv").open("w", newline="") as file:
        csv.writer(file).writerows([("episode", "return", "length"), *rows])
    log = read(tmp_path / "0.csv")
    assert log["reward/recorded"] == pytest.approx(list(env.return_queue), rel=1e-6)
    assert log["length"].tolist() == list(env.length_queue)
    assert log["time"].tolist() == [7, 14, 21, 28, 35]
    assert log.facts.unit == "episode"


@pytest.mark.parametrize(
    "header",
    [
        "episode,reward,length",
        "Episode,Return,Steps",
        "ep,ep_rew,ep_len",
        "episode;total_reward;episode_length",
        "i_episode\tscore\tl",
    ],
)
def test_names_that_people_use_give_the_same(tmp_path, header):
    """In any case, with commas, semicolons and tabs."""
    separator = next(sign for sign in ",;\t" if sign in header)
    log = read(written(tmp_path, header + "\n" + ROWS.replace(",", separator)))
    assert log["reward/recorded"].tolist() == [-9.5, -7.25, -3.0]
    assert log["length"].tolist() == [200, 180, 150]
    assert log["time"].tolist() == [200, 380, 530]


def test_an_episode_that_stands_twice_is_refused_by_its_line(tmp_path):
    """Far down, where nobody looks first: the table is one of steps after all, or of two runs, one behind the other."""
    rows = "".join(f"{number},1.0\n" for number in range(2000))
    with pytest.raises(SchemaError, match=r"0\.csv, line 2002: episode 1999 stands twice"):
        read(written(tmp_path, f"episode,reward\n{rows}1999,1.0\n"))
    with pytest.raises(SchemaError, match="line 5: it goes back to episode 0: the file holds several runs"):
        read(written(tmp_path, "episode,reward,length\n" + ROWS + ROWS))


def test_a_seed_of_each_episode_is_no_run(tmp_path):
    """Evaluations are often seeded one by one."""
    log = read(written(tmp_path, "episode,reward,seed\n0,-1.0,100\n1,-2.0,101\n2,-3.0,102\n"))
    assert len(log) == 3


def test_episodes_of_several_envs_are_counted_in_each(tmp_path):
    """A column says which."""
    log = read(written(tmp_path, "env,episode,reward,length\n0,0,-1,5\n1,0,-2,6\n0,1,-3,7\n1,1,-4,8\n"))
    assert log["time"].tolist() == [5, 11, 18, 26]


def test_episodes_that_are_missing_are_told_and_no_steps_are_made_up(tmp_path):
    """Only every tenth episode was written down."""
    log = read(written(tmp_path, "episode,reward,length\n0,-1.0,50\n10,-2.0,50\n20,-3.0,50\n"))
    assert "time" not in log
    assert "not every episode" in log.facts.thinned


def test_steps_that_only_rise_are_those_of_all_episodes(tmp_path):
    """`steps` is the length of an episode for some, and what was done so far for others."""
    rows = "".join(f"{number},-1.0,{200 * (number + 1)}\n" for number in range(6))
    log = read(written(tmp_path, f"episode,reward,steps\n{rows}"))
    assert log["time"].tolist() == [200, 400, 600, 800, 1000, 1200]
    assert "length" not in log


def test_a_column_of_steps_of_the_training_is_time(tmp_path):
    """And may not go back."""
    log = read(written(tmp_path, "episode,reward,total_steps\n0,-1.0,200\n1,-2.0,390\n"))
    assert log["time"].tolist() == [200, 390]
    with pytest.raises(SchemaError, match="line 3: 'total_steps' goes back"):
        read(written(tmp_path, "episode,reward,total_steps\n0,-1.0,200\n1,-2.0,190\n"))


def test_a_damaged_row_is_refused_by_its_line(tmp_path_factory, subtests):
    """Never read in part."""
    rows = [
        ("3,-1.0,0", "line 5: column 'length' counts from 1, and holds 0"),
        ("3,-1.0,12.5", "line 5: column 'length' counts from 1"),
        ("3,-1.0", "line 5: it has 2 cells"),
    ]
    for row, why in rows:
        with subtests.test(row=row, why=why):
            tmp_path = tmp_path_factory.mktemp("case")
            path = written(tmp_path, f"episode,reward,length\n{ROWS}{row}\n")
            with pytest.raises(SchemaError, match=why):
                read.make().read(path)


def test_a_table_without_a_column_of_returns_is_told_how_to_name_it(tmp_path):
    """With what there is."""
    path = written(tmp_path, "episode,points\n0,1.0\n1,2.0\n")
    with pytest.raises(UsageError, match=r"say reward=NAME. It has: episode, points"):
        read.make().read(path)
    [log] = read.make(reward="points").read(path)
    assert log["reward/recorded"].tolist() == [1.0, 2.0]
