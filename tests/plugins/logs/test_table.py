"""Tables that people write themselves: what a row is, of which training it is, and what is asked."""

import pytest

from harness.errors import AskedError, UsageError
from harness.log.open_log import find_logs, open_logs
from harness.registry import load_registry
from tests.plugins.logs.reading import Reader

read = Reader("table", "own.csv")
TIDY = "".join(f"{name},{seed},{at},{at - 5},10\n" for name in ("base", "prop") for seed in (0, 1) for at in range(3))
CURVES = "".join(f"{name},{at},{at / 100}\n" for name in ("a", "b") for at in (10, 20))


@pytest.mark.parametrize(
    ("text", "unit", "columns"),
    [
        ("timesteps,return\n100,1\n200,2\n300,3\n", "point", {"time": [100, 200, 300]}),
        ("Episode,Steps,Avg Reward (100)\n0,200,1\n1,180,2\n", "point", {"iteration": [0, 1]}),
        ("episode,reward,steps\n0,1,200\n1,2,210\n", "episode", {"length": [200, 210], "time": [200, 410]}),
        ("global_step,episodic_return,episodic_length\n8,1,8\n16,2,8\n", "point", {"time": [8, 16], "since": [0, 8]}),
        ('{"step": 500, "episode/score": 1, "episode/length": 100}\n', "point", {"time": [500], "since": [400]}),
        ("epoch,train/return,eval/return,eval/success\n1,1,2,0\n2,2,3,1\n", "point", {"reward/recorded": [2, 3]}),
        ("timestep,average_return\n10,1\n20,2\n", "point", {"iteration": [10, 20]}),
    ],
)
def test_what_a_row_is_and_what_counts_the_steps(tmp_path, text, unit, columns):
    """By the names of columns, and by whether they only rise."""
    log = read(read.written(tmp_path, text))
    assert log.facts.unit == unit
    assert {name: log[name].tolist() for name in columns} == columns


def test_a_column_of_words_that_is_called_so_names_the_reward(tmp_path):
    """Seeds tell the trainings of each; a seed that is the same in all rows is that of the file."""
    logs = read.logs(read.written(tmp_path, f"method,seed,episode,return,length\n{TIDY}"))
    assert [(log.facts.run, log.facts.seed) for log in logs] == [
        ("base_0", 0),
        ("base_1", 1),
        ("prop_0", 0),
        ("prop_1", 1),
    ]
    assert read(read.written(tmp_path, "seed,timesteps,return\n7,1,1\n7,2,2\n")).facts.seed == 7


def test_a_column_that_nobody_uses_is_named(tmp_path):
    """Dates, and texts that stand in some rows alone, are no question."""
    text = "timesteps,return,note,date,lr\n1,1,,2024-01-01,0.1\n2,2,restart,2024-01-02,0.1\n3,3,,2024-01-02,0.1\n"
    assert "not used: note, date, lr" in read(read.written(tmp_path, text)).facts.notes


def test_a_column_that_may_name_trainings_is_asked_about(tmp_path):
    """Both answers can be typed, with what was said before; a mode or an agent names none."""
    path = read.written(tmp_path, f"place,total_steps,mine\n{CURVES}")
    with pytest.raises(AskedError) as asked:
        read.make(reward="mine").read(path)
    assert "'table:reward=mine,only=place=b'" in str(asked.value)
    assert "'table:reward=mine,run=place'" in str(asked.value)
    [log] = read.make(reward="mine", only="place=b").read(path)
    assert log["time"].tolist() == [10, 20]
    assert [log.facts.run for log in read.make(reward="mine", run="place").read(path)] == ["a", "b"]
    with pytest.raises(UsageError, match=r"no row has 'c' in its column 'place'. There is: a, b"):
        read.make(reward="mine", only="place=c").read(path)
    path = read.written(tmp_path, f"mode,total_steps,success\n{CURVES}")
    with pytest.raises(AskedError, match=r"only=mode=b' reads those of one$"):
        find_logs(tmp_path, load_registry())


def test_charts_that_lie_beside_one_another_are_joined_by_run(tmp_path):
    """Each panel of Weights & Biases is exported by itself."""
    for number, tag in enumerate(("rollout/ep_rew_mean", "rollout/success_rate")):
        names = ",".join(f'"{run} - {tag}{end}"' for run in ("base_0", "prop_0") for end in ("", "__MIN", "__MAX"))
        rows = "\n".join(f'"{step}",' + ",".join(['"0.5"'] * 6) for step in (100, 200))
        (tmp_path / f"wandb_export_{number}.csv").write_text(f'"global_step",{names}\n{rows}')
    logs = find_logs(tmp_path, load_registry()).logs
    assert [log.facts.run for log in logs] == ["base_0", "prop_0"]
    assert all({"reward/recorded", "behaviour/success"} <= {*log.columns} for log in logs)


def test_a_format_of_earlier_versions_says_what_to_type(tmp_path):
    """With the settings that were typed, which then do what they did."""
    path = read.written(tmp_path, "rounds,points\n1,2\n2,3\n")
    with pytest.raises(UsageError, match=r"'progress-csv' is gone: .* Type --as 'table:reward=points'"):
        open_logs(path, load_registry(), "progress-csv:reward=points")
    [log] = open_logs(path, load_registry(), "table:reward=points")
    assert (log.facts.reader, log["reward/recorded"].tolist()) == ("table", [2, 3])
