"""Files that stable-baselines3's Monitor and VecMonitor write, and what happens to such files."""

import json
import warnings

import numpy as np
import pytest

from harness.errors import SchemaError, UsageError
from tests.plugins.logs.reading import Reader

pytest.importorskip("stable_baselines3", reason="needs the extra sb3")

HEADER = '#{"t_start": 1700000000.5, "env_id": "Toy-v0"}\n'
ROWS = "-3.5,10,0.5\n-2.25,12,1.25\n-1.0,9,2.0\n"


def monitored(make, path, episodes, **keywords):
    """The library's Monitor, closed after so many episodes."""
    from stable_baselines3.common.monitor import Monitor as Wrapper

    env = Wrapper(make(), str(path), **keywords)
    for _ in range(episodes):
        env.reset()
        while not env.needs_reset:
            env.step(env.action_space.sample())
    env.close()
    return env


read = Reader("table", "monitor.csv")
written = read.written


def test_returns_and_lengths_are_those_that_monitor_holds_in_memory(counted, tmp_path):
    """The file of the library against its own lists."""
    env = monitored(counted, tmp_path / "monitor.csv", 6)
    log = read(tmp_path / "monitor.csv")
    assert log["reward/recorded"] == pytest.approx(env.get_episode_rewards(), abs=1e-6)
    assert log["length"].tolist() == env.get_episode_lengths()
    assert log["time"][-1] == env.get_total_steps()
    assert log.facts.unit == "episode"


def test_vec_monitor_of_several_envs_is_one_log(counted, counted_returns, tmp_path):
    """Episodes of three envs end together, in the order of the envs."""
    from stable_baselines3.common.vec_env import DummyVecEnv, VecMonitor

    envs = VecMonitor(DummyVecEnv([counted] * 3), str(tmp_path / "all"))
    envs.reset()
    for _ in range(2 + 3):
        envs.step(np.zeros((3, 1), np.float32))
    envs.close()
    log = read(tmp_path / "all.monitor.csv")
    assert log["reward/recorded"] == pytest.approx(np.repeat(counted_returns([0, 1]), 3), abs=1e-6)
    assert log["time"].tolist() == [2, 4, 6, 9, 12, 15]


def test_info_keywords_give_success_and_measures(counted, tmp_path):
    """True and False are 1 and 0; a column of text is left out, and told."""
    keys = ("is_success", "distance", "phase")
    monitored(counted, tmp_path / "monitor.csv", 4, info_keywords=keys)
    log = read(tmp_path / "monitor.csv")
    assert log["behaviour/success"].tolist() == [0, 1, 0, 1]
    assert log["behaviour/distance"].tolist() == [0.0, 0.5, 1.0, 1.5]
    assert log.measures == ("success", "distance")
    assert any("phase" in note for note in log.facts.notes)


def test_files_of_several_envs_tell_when_they_began_and_each_episode_ended(counted, tmp_path):
    """Whoever joins the envs of one training, as the library's own reader does, needs both."""
    from stable_baselines3.common.env_util import make_vec_env

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        envs = make_vec_env(counted, n_envs=3, monitor_dir=str(tmp_path))
    envs.reset()
    envs.step(np.zeros((3, 1), np.float32))
    envs.step(np.zeros((3, 1), np.float32))
    envs.close()
    logs = [read(path) for path in sorted(tmp_path.iterdir())]
    told = [json.loads(path.read_text().partition("\n")[0][1:])["t_start"] for path in sorted(tmp_path.iterdir())]
    assert [log.facts.started for log in logs] == told
    assert all(0.0 <= log["seconds"][0] < 60.0 for log in logs)


def test_a_file_that_monitor_appended_to_is_read_whole(counted, counted_returns, tmp_path):
    """`override_existing=False`, as in a job that is started again."""
    path = tmp_path / "monitor.csv"
    monitored(counted, path, 40)
    monitored(counted, path, 2, override_existing=False)
    log = read(path)
    assert log["reward/recorded"] == pytest.approx(counted_returns([*range(40), 0, 1]), abs=1e-6)
    assert any("goes back 1 times, first in line 43" in note for note in log.facts.notes)


def test_a_file_without_a_header_is_read_as_issue_2282_of_the_library_has_it(counted, counted_returns, tmp_path):
    """`override_existing=False` of a file that was not there writes rows alone; its own reader refuses it."""
    path = tmp_path / "run.monitor.csv"
    monitored(counted, path, 3, override_existing=False, info_keywords=("is_success",))
    assert not path.read_text().startswith("#")
    log = read(path)
    assert log["reward/recorded"] == pytest.approx(counted_returns([0, 1, 2]), abs=1e-6)
    assert log["length"].tolist() == [2, 3, 4]
    assert read(path, success="column 4")["behaviour/success"].tolist() == [0, 1, 0]


def test_lengths_that_count_up_are_lengths(tmp_path):
    """A row of Monitor is never a step."""
    log = read(written(tmp_path, f"{HEADER}r,l,t\n-3,1,0.5\n-2,2,1\n-1,3,2\n-1,4,3\n-1,5,4\n"))
    assert log["length"].tolist() == [1, 2, 3, 4, 5]
    assert log["time"].tolist() == [1, 3, 6, 10, 15]


def test_two_files_joined_into_one_are_one_log(tmp_path):
    """Both headers stand in it."""
    log = read(written(tmp_path, 2 * (HEADER + "r,l,t\n" + ROWS)))
    assert log["reward/recorded"].tolist() == [-3.5, -2.25, -1.0] * 2
    assert log["time"].tolist() == [10, 22, 31, 41, 53, 62]


def test_two_environments_in_one_file_are_refused(tmp_path):
    """Their returns have nothing to do with one another."""
    text = HEADER + "r,l,t\n" + ROWS
    with pytest.raises(SchemaError, match="several environments: Other-v0, Toy-v0"):
        read(written(tmp_path, text + text.replace("Toy", "Other")))


def test_a_damaged_row_is_refused_by_its_line(tmp_path_factory, subtests):
    """Never read in part; in issue 647 of the library a row holds the cells of two processes."""
    rows = [
        ("61,62,36.887254181,182,39.867808", "line 6: it has 5 cells"),
        (",9,3.0", "line 6: column 'r' holds nothing"),
        ("-1.0,0,3.0", "line 6: column 'l' counts from 1"),
        ("-1.0,9.5,3.0", "line 6: column 'l' counts from 1"),
    ]
    for row, why in rows:
        with subtests.test(row=row, why=why):
            tmp_path = tmp_path_factory.mktemp("case")
            with pytest.raises(SchemaError, match=why):
                read(written(tmp_path, f"{HEADER}r,l,t\n{ROWS}{row}\n{ROWS}"))


@pytest.mark.parametrize(
    "text",
    [
        '# {"t_start": 1, "env_id": "Toy-v0"}\nr,l,t\n' + ROWS,
        (HEADER + "r,l,t\n" + ROWS).replace("\n", "\r\n"),
        (HEADER + "r,l,t\n" + ROWS).replace("\n", "\r\n\r\n"),
        "\ufeff" + HEADER + "r,l,t\n" + ROWS,
    ],
    ids=["blank before the JSON", "Windows", "Windows, blank lines", "byte order mark"],
)
def test_other_ways_to_write_the_same_file_give_the_same(tmp_path, text):
    """Older versions, and other systems."""
    log = read(written(tmp_path, text))
    assert log["reward/recorded"].tolist() == [-3.5, -2.25, -1.0]
    assert log["length"].tolist() == [10, 12, 9]
    assert log.facts.env == "Toy-v0"


def test_a_header_that_names_no_environment_names_none(tmp_path):
    """Monitor writes the text None, old versions null."""
    for name in ('"None"', "null"):
        text = f'#{{"t_start": 1, "env_id": {name}}}\nr,l,t\n{ROWS}'
        assert read(written(tmp_path, text)).facts.env == ""


def test_a_file_without_an_episode_is_refused(tmp_path):
    """A training that has just begun."""
    with pytest.raises(SchemaError, match="no episode yet"):
        read(written(tmp_path, HEADER + "r,l,t\n"))


def test_a_column_of_success_that_is_not_there_is_told(tmp_path):
    """With what there is."""
    with pytest.raises(UsageError, match=r"has no 'succes'\. It has: r, l, t"):
        read(written(tmp_path, HEADER + "r,l,t\n" + ROWS), success="succes")


def test_pay_among_the_further_columns_is_no_measure(tmp_path):
    """What a term of the reward paid is part of the reward."""
    log = read(written(tmp_path, HEADER + "r,l,t,reward_ctrl,distance\n-1.0,9,1.0,-0.5,0.25\n"))
    assert log.measures == ("distance",)


def test_tables_of_others_are_not_recognised(tmp_path):
    """Nor a file of another name without a header."""
    for name, text in [("monitor.csv", "reward\n1\n2\n"), ("rows.csv", ROWS), ("e", "")]:
        path = written(tmp_path, text, name)
        assert not read.is_recognised(path)
