"""Tables of progress that stable-baselines3's own logger writes, and what happens to such tables."""

import json

import pytest

from harness.errors import SchemaError
from tests.plugins.logs.reading import Reader

REWARD, STEPS = "rollout/ep_rew_mean", "time/total_timesteps"

read = Reader("table", "progress.csv")
written = read.written


def logged(folder, reports):
    """What stable-baselines3's own logger wrote of reports."""
    logger = pytest.importorskip("stable_baselines3.common.logger", reason="needs the extra sb3")
    writer = logger.CSVOutputFormat(str(folder / "progress.csv"))
    for report in reports:
        writer.write(dict(report), dict.fromkeys(report, ()))
    writer.close()
    return folder / "progress.csv"


def test_keys_that_come_later_stand_under_their_names(tmp_path):
    """Issue 774 of baselines: a table whose header grows on the way. The library pads the rows before."""
    reports = [
        {STEPS: 100, REWARD: -9.5},
        {"aaa/new": 1.0, STEPS: 200, REWARD: -8.25},
        {STEPS: 300, "rollout/success_rate": 0.5, REWARD: -7.125, "aaa/new": 2.0},
        {REWARD: -6.0625, STEPS: 400, "rollout/success_rate": 0.75},
    ]
    log = read(logged(tmp_path, reports))
    assert log["time"].tolist() == [300, 400]
    assert log["reward/recorded"].tolist() == [-7.125, -6.0625]
    assert log["behaviour/success"].tolist() == [0.5, 0.75]
    assert any("2 points that lack one of these are left out" in note for note in log.facts.notes)


def test_values_under_names_of_others_are_refused_by_the_counter(tmp_path):
    """As wide as the header, but in another order: steps are whole numbers, returns mostly not."""
    path = written(tmp_path, f"{REWARD},{STEPS}\n-9.5,100\n200,-8.25\n")
    with pytest.raises(SchemaError, match=r"line 3: column 'time/total_timesteps' counts from 0, and holds -8\.25"):
        read(path)


def test_evaluations_in_rows_of_their_own_are_read_where_they_have_success(tmp_path):
    """EvalCallback dumps rows of its own into the same table."""
    reports = [
        {STEPS: 100, REWARD: -9.5},
        {STEPS: 150, "eval/mean_reward": -8.0, "eval/success_rate": 0.25, "eval/mean_ep_length": 20.0},
        {STEPS: 200, REWARD: -7.5},
    ]
    log = read(logged(tmp_path, reports))
    assert log["time"].tolist() == [150]
    assert log.facts.evaluation
    assert read(tmp_path / "progress.csv", reward=REWARD)["time"].tolist() == [100, 200]


def test_a_trial_that_was_restored_has_its_later_rows_count(tmp_path):
    """Issue 4187 of Ray: what was reported again after a checkpoint stands in the table twice."""
    rows = "1,1000,1\n2,2000,2\n3,3000,3\n2,2000,20\n3,3000,30\n"
    log = read(written(tmp_path, f"training_iteration,timesteps_total,episode_reward_mean\n{rows}"))
    assert log["time"].tolist() == [1000, 2000, 3000]
    assert log["reward/recorded"].tolist() == [1.0, 20.0, 30.0]


def test_seed_and_environment_of_a_trial_stand_beside_it(tmp_path):
    """In params.json, which Ray writes."""
    (tmp_path / "params.json").write_text(json.dumps({"env": "Hopper-v4", "seed": 11, "lr": 0.1}))
    path = written(tmp_path, "training_iteration,timesteps_total,episode_reward_mean\n1,1000,2.5\n")
    assert (read(path).facts.env, read(path).facts.seed) == ("Hopper-v4", 11)


def test_a_header_longer_than_what_is_looked_at_first_is_recognised(tmp_path):
    """RLlib has hundreds of columns."""
    more = ",".join(f"info/learner/default_policy/statistic_{number}" for number in range(300))
    zeros = ",".join(["0"] * 300)
    path = written(tmp_path, f"{more},timesteps_total,episode_reward_mean\n{zeros},1000,2.5\n")
    assert read(path)["reward/recorded"].tolist() == [2.5]


@pytest.mark.parametrize(
    ("header", "point"),
    [
        ("eprewmean,misc/total_timesteps", "last 100"),
        ("EpRewMean,TimestepsSoFar", "last 100"),
        ("AverageEpRet\tTotalEnvInteracts", "since the point before"),
        ("Evaluation/AverageReturn,TotalEnvSteps", "of an evaluation"),
        ("episode_reward_mean,timesteps_total", "of an iteration"),
    ],
)
def test_tables_of_other_programs_are_found_by_their_columns(tmp_path, header, point):
    """With environment steps from the column that the program counts them in; Spinning Up's has tabs."""
    separator = "\t" if "\t" in header else ","
    path = written(tmp_path, f"{header}\n-9.5{separator}100\n-8.25{separator}200\n")
    log = read(path)
    assert log["time"].tolist() == [100, 200]
    assert log["reward/recorded"].tolist() == [-9.5, -8.25]
    assert point in log.facts.thinned


def test_a_counter_without_a_number_is_passed_over(tmp_path):
    """RLlib has columns of older versions that nobody fills any more."""
    header = "num_env_steps_sampled_lifetime,timesteps_total,episode_reward_mean"
    path = written(tmp_path, f"{header}\n,1000,2.5\n,2000,3.5\n")
    assert read(path)["time"].tolist() == [1000, 2000]


@pytest.mark.parametrize("text", [f"{REWARD},{STEPS}\n", f"{REWARD},{STEPS}\n,100\n", f"{REWARD},{STEPS}\nnan,100\n"])
def test_a_table_without_a_point_is_refused(tmp_path, text):
    """No episode has ended yet."""
    with pytest.raises(SchemaError, match="has no point of rollout/ep_rew_mean"):
        read(written(tmp_path, text))
