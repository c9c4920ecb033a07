"""Tables that people write themselves: what a row is, of which training it is, and what is asked."""

import pytest

from harness.errors import AskedError, SchemaError, UsageError
from harness.log import open_logs
from harness.log.open_log import find_logs
from tests.plugins.logs.reading import Reader
from tests.registered import REGISTRY

read = Reader("table", "own.csv")
TIDY = "".join(f"{name},{seed},{at},{at - 5},10\n" for name in ("base", "prop") for seed in (0, 1) for at in range(3))
CURVES = "".join(f"{name},{at},{at / 100}\n" for name in ("a", "b") for at in (10, 20))
HEADER = '#{"t_start": 1700000000.5, "env_id": "Toy-v0"}\n'
MONITORED = HEADER + "r,l,t\n-3.5,10,0.5\n-2.25,12,1.25\n-1.0,9,2.0\n"
"""As stable-baselines3's Monitor writes it."""
OF_THREE = {"reward/recorded": [-3.5, -2.25, -1.0], "length": [10, 12, 9], "time": [10, 22, 31]}
EPISODES = "0,-9.5,200\n1,-7.25,180\n2,-3.0,150\n"
OF_EPISODES = {"reward/recorded": [-9.5, -7.25, -3.0], "length": [200, 180, 150], "time": [200, 380, 530]}
POINTS = "\n-9.5,100\n-8.25,200\n"
OF_POINTS = {"reward/recorded": [-9.5, -8.25], "time": [100, 200]}
POINT, EPISODE, OF_TOY = "unit='point'", "unit='episode'", "env='Toy-v0'"
SAMPLED = "Weights & Biases samples a curve before it exports it"
MEANS = "rollout/ep_rew_mean,time/total_timesteps\n"
EXPORT = "Wall time,Step,Value\r\n1700000000.5,2048,0.25\r\n1700000001.5,4096,0.5\r\n"
MANY = "".join(f"{number},1.0\n" for number in range(2000))
HUNDREDS = "".join(f"info/learner/{number}," for number in range(400))
TAG = "ppo - charts/episodic_return"
CHART = f'"global_step","{TAG}","{TAG}__MIN","{TAG}__MAX"'


@pytest.mark.parametrize(
    ("text", "told", "columns"),
    [
        ("timesteps,return\n100,1\n200,2\n300,3\n", POINT, {"time": [100, 200, 300]}),
        ("Episode,Steps,Avg Reward (100)\n0,200,1\n1,180,2\n", POINT, {"iteration": [0, 1]}),
        ("episode,reward,steps\n0,1,200\n1,2,210\n", EPISODE, {"length": [200, 210], "time": [200, 410]}),
        ("global_step,episodic_return,episodic_length\n8,1,8\n16,2,8\n", POINT, {"time": [8, 16], "since": [0, 8]}),
        ('{"step": 500, "episode/score": 1, "episode/length": 100}\n', POINT, {"time": [500], "since": [400]}),
        ("epoch,train/return,eval/return,eval/success\n1,1,2,0\n2,2,3,1\n", POINT, {"reward/recorded": [2, 3]}),
        ("timestep,average_return\n10,1\n20,2\n", POINT, {"iteration": [10, 20]}),
        # What people call episodes, with commas, semicolons and tabs; the first is what gymnasium's statistics tell
        (f"episode,return,length\n{EPISODES}", EPISODE, OF_EPISODES),
        (f"Episode,Return,Steps\n{EPISODES}", EPISODE, OF_EPISODES),
        (f"ep,ep_rew,ep_len\n{EPISODES}", EPISODE, OF_EPISODES),
        (f"episode,total_reward,episode_length\n{EPISODES}".replace(",", ";"), EPISODE, OF_EPISODES),
        (f"i_episode,score,l\n{EPISODES}".replace(",", "\t"), EPISODE, OF_EPISODES),
        # A seed of each episode is no run: evaluations are often seeded one by one
        ("episode,reward,seed\n0,-1.0,100\n1,-2.0,101\n", EPISODE, {"reward/recorded": [-1, -2]}),
        # Episodes of several envs are counted in each
        ("env,episode,reward,length\n0,0,-1,5\n1,0,-2,6\n0,1,-3,7\n1,1,-4,8\n", EPISODE, {"time": [5, 11, 18, 26]}),
        # Where nothing counts, a clock that falls says that the newest episode stands first
        (
            "date,return,length\n" + "".join(f"2026-11-30 10:0{5 - k},{5 - k},7\n" for k in range(5)),
            "'date' falls from row to row",
            {"reward/recorded": [1, 2, 3, 4, 5]},
        ),
        # Only every tenth episode was written down: no steps are made up
        ("episode,reward,length\n0,-1.0,50\n10,-2.0,50\n20,-3.0,50\n", "not every episode", {"time": None}),
        # Steps that only rise are those of all episodes, and a column of steps of the training is time
        (
            "episode,reward,steps\n0,-1,200\n1,-1,400\n2,-1,600\n3,-1,800\n4,-1,1000\n5,-1,1200\n",
            EPISODE,
            {"time": [200, 400, 600, 800, 1000, 1200], "length": None},
        ),
        ("episode,reward,total_steps\n0,-1.0,200\n1,-2.0,390\n", EPISODE, {"time": [200, 390]}),
        # Other programs count environment steps in columns of their own; Spinning Up's has tabs
        (f"eprewmean,misc/total_timesteps{POINTS}", "last 100", OF_POINTS),
        (f"EpRewMean,TimestepsSoFar{POINTS}", "last 100", OF_POINTS),
        (f"AverageEpRet,TotalEnvInteracts{POINTS}".replace(",", "\t"), "since the point before", OF_POINTS),
        (f"Evaluation/AverageReturn,TotalEnvSteps{POINTS}", "of an evaluation", OF_POINTS),
        (f"episode_reward_mean,timesteps_total{POINTS}", "of an iteration", OF_POINTS),
        # RLlib has columns of older versions that nobody fills any more, and hundreds: more than is looked at first
        (
            "num_env_steps_sampled_lifetime,timesteps_total,episode_reward_mean\n,1000,2.5\n,2000,3.5\n",
            POINT,
            {"time": [1000, 2000]},
        ),
        (f"{HUNDREDS}timesteps_total,episode_reward_mean\n{'0,' * 400}1,2\n", POINT, {"time": [1]}),
        # Of a trial that was restored the later rows count: issue 4187 of Ray
        (
            "training_iteration,timesteps_total,episode_reward_mean\n1,10,1\n2,20,2\n3,30,3\n2,20,20\n3,30,30\n",
            POINT,
            {"time": [10, 20, 30], "reward/recorded": [1, 20, 30]},
        ),
        # A row of Monitor is never a step; files that were joined are one log
        (f"{HEADER}r,l,t\n-3,1,0.5\n-2,2,1\n-1,3,2\n", EPISODE, {"length": [1, 2, 3], "time": [1, 3, 6]}),
        (
            2 * MONITORED,
            EPISODE,
            {"reward/recorded": [-3.5, -2.25, -1.0] * 2, "time": [10, 22, 31, 41, 53, 62]},
        ),
        # Older versions of it, and other systems, write the same in other ways
        (MONITORED.replace("#", "# "), OF_TOY, OF_THREE),
        (MONITORED.replace("\n", "\r\n"), OF_TOY, OF_THREE),
        (MONITORED.replace("\n", "\r\n\r\n"), OF_TOY, OF_THREE),
        ("\ufeff" + MONITORED, OF_TOY, OF_THREE),
        # A header of it that names no environment says None, or null in old versions
        (MONITORED.replace("Toy-v0", "None"), "env=''", OF_THREE),
        (MONITORED.replace('"Toy-v0"', "null"), "env=''", OF_THREE),
        # What a term of the reward paid is part of the reward, and no measure
        (
            f"{HEADER}r,l,t,reward_ctrl,distance\n-1.0,9,1.0,-0.5,0.25\n",
            EPISODE,
            {"behaviour/distance": [0.25], "behaviour/reward_ctrl": None},
        ),
        # Weights & Biases samples a curve before it exports it, and joins its points or those of a group of runs
        (f'{CHART}\n"0","2","2","2"\n', f"thinned='{SAMPLED}'", {"reward/recorded": [2]}),
        (f'{CHART}\n"0","2","1","3"\n', "or of the runs of a group", {"reward/recorded": [2]}),
        # A run of CleanRL tells what it is by its name; one may be called anything, and `_step` is no curve
        (
            f'{CHART}\n"0","2","2","2"\n'.replace("ppo - ", "Hopper-v4__ppo__5__1700000000 - "),
            "env='Hopper-v4', algorithm='ppo', seed=5",
            {"reward/recorded": [2]},
        ),
        (
            f'{CHART},"my - base - _step"\n"0","2","2","2","1"\n'.replace("ppo", "my - base"),
            "run='my - base'",
            {"reward/recorded": [2]},
        ),
        # The history of a run as its interface gives it: `global_step` as what it logged counts steps
        (
            ",_step,_runtime,_timestamp,global_step,charts/episodic_return,losses/v\n"
            "0,0,1.5,1700000000,128,-2.5,\n1,1,2.5,1700000001,128,,0.5\n2,2,3.5,1700000002,256,-1.25,\n",
            "samples",
            {"time": [128, 256], "reward/recorded": [-2.5, -1.25]},
        ),
    ],
)
def test_what_a_row_is_and_what_counts_the_steps(tmp_path, text, told, columns):
    """By the names of columns, and by whether they only rise."""
    log = read(read.written(tmp_path, text))
    assert told in repr(log.facts)
    assert {name: log[name].tolist() if name in log else None for name in columns} == columns


@pytest.mark.parametrize(
    ("text", "why"),
    [
        # A damaged row is never read in part; in issue 647 of stable-baselines a row holds the cells of two processes
        (f"{MONITORED}61,62,36.887254181,182,39.867808\n{MONITORED}", "line 6: it has 5 cells"),
        (f"{MONITORED},9,3.0\n", "line 6: column 'r' holds nothing"),
        (f"{MONITORED}-1.0,0,3.0\n", "line 6: column 'l' counts from 1, and holds 0"),
        (f"{MONITORED}-1.0,9.5,3.0\n", "line 6: column 'l' counts from 1"),
        (f"episode,reward,length\n{EPISODES}3,-1.0,0\n", "line 5: column 'length' counts from 1, and holds 0"),
        # Nobody knows what a counter that begins again counts
        (
            "timesteps,success_rate\n" + "".join(f"{10 * step},0.1\n" for step in (*range(1, 9), *range(1, 9))),
            "own.csv: its steps go from 80 to 10: it holds several trainings, or one whose steps",
        ),
        # Returns of two environments have nothing to do with one another
        (MONITORED + MONITORED.replace("Toy", "Other"), "several environments: Other-v0, Toy-v0"),
        # A training has just begun
        (f"{HEADER}r,l,t\n", "no episode yet"),
        (MEANS, "has no point of rollout/ep_rew_mean"),
        (f"{MEANS},100\n", "has no point of rollout/ep_rew_mean"),
        (f"{MEANS}nan,100\n", "has no point of rollout/ep_rew_mean"),
        # Values stand under names of others: steps are whole numbers, returns mostly not
        (f"{MEANS}-9.5,100\n200,-8.25\n", r"line 3: column 'time/total_timesteps' counts from 0, and holds -8\.25"),
        # An episode stands twice, far down where nobody looks first: rows are steps after all, or of two runs
        (
            f"episode,reward\n{MANY}1999,1.0\n",
            r"own\.csv, line 2002: episode 1999 stands twice",
        ),
        (f"episode,reward,length\n{2 * EPISODES}", "line 5: it goes back to episode 0: the file holds several runs"),
        ("episode,reward,total_steps\n0,-1.0,200\n1,-2.0,190\n", "line 3: 'total_steps' goes back"),
    ],
)
def test_what_is_damaged_is_refused(tmp_path, text, why):
    """By its line, where one is to blame."""
    with pytest.raises(SchemaError, match=why):
        read(read.written(tmp_path, text))


@pytest.mark.parametrize(
    ("text", "given", "told"),
    [
        (MONITORED, {"success": "succes"}, r"has no 'succes'\. It has: r, l, t"),
        ("episode,points\n0,1.0\n1,2.0\n", {}, r"say reward=NAME. It has: episode, points"),
        (EXPORT, {}, r"say reward=NAME. It has: Wall time, Step, Value"),
    ],
)
def test_a_column_that_is_not_known_is_to_be_named(tmp_path, text, given, told):
    """With what there is: a file of another name, for one, does not tell what TensorBoard's page exported into it."""
    with pytest.raises(UsageError, match=told):
        read.make(**given).read(read.written(tmp_path, text))


def test_what_the_user_says_that_a_column_is_counts(tmp_path):
    """Its name does not tell."""
    path = read.written(tmp_path, EXPORT)
    assert read(path, success="Value")["behaviour/success"].tolist() == [0.25, 0.5]
    assert read(path, reward="Value", per_step=1)["time"].tolist() == [2048, 4096]


@pytest.mark.parametrize("text", ["reward\n1\n2\n", EPISODES, "", "loss - total\n1,2\n", "x,a-b\n1,2\n"])
def test_tables_of_others_are_not_recognised(tmp_path, text):
    """Nor a file of another name without a header, nor a name with a dash."""
    assert not read.is_recognised(read.written(tmp_path, text))


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
        find_logs(tmp_path, REGISTRY)


def test_charts_that_lie_beside_one_another_are_joined_by_run(tmp_path):
    """Each panel of Weights & Biases is exported by itself."""
    for number, tag in enumerate(("rollout/ep_rew_mean", "rollout/success_rate")):
        names = ",".join(f'"{run} - {tag}{end}"' for run in ("base_0", "prop_0") for end in ("", "__MIN", "__MAX"))
        rows = "\n".join(f'"{step}",' + ",".join(['"0.5"'] * 6) for step in (100, 200))
        (tmp_path / f"wandb_export_{number}.csv").write_text(f'"global_step",{names}\n{rows}')
    logs = find_logs(tmp_path, REGISTRY).logs
    assert [log.facts.run for log in logs] == ["base_0", "prop_0"]
    assert all({"reward/recorded", "behaviour/success"} <= {*log.columns} for log in logs)


def test_a_format_of_earlier_versions_says_what_to_type(tmp_path):
    """With the settings that were typed, which then do what they did."""
    path = read.written(tmp_path, "rounds,points\n1,2\n2,3\n")
    with pytest.raises(UsageError, match=r"'progress-csv' is gone: .* Type --as 'table:reward=points'"):
        open_logs(path, REGISTRY, "progress-csv:reward=points")
    [log] = open_logs(path, REGISTRY, "table:reward=points")
    assert (log.facts.reader, log["reward/recorded"].tolist()) == ("table", [2, 3])
