import numpy as np
import pytest

from harness.errors import UsageError
from harness.log import LogFacts, in_memory
from harness.results.logs.trainings import require_several, sort_logs
from tests.results.logs.conftest import sorts_of


def keys(found):
    """The reward, the seed and the number of files of each training."""
    return [(it.reward, it.seed, len(it.logs)) for it in found.trainings]


def curve(path, **facts):
    """A log of three points, whose numbers depend on its path."""
    points = np.arange(3.0) + sum(map(ord, str(path)))
    told = LogFacts(path=path, **{"format": "TensorBoard", "unit": "point", **facts})
    return in_memory(told, {"time": np.array([10.0, 20.0, 30.0]), "reward/recorded": points})


def batch(monitor, folder, *, paid, envs=3, started=1.7e9):
    """Files of environments that one training steps together."""
    for env in range(envs):
        ends = [number + 1e-4 * env for number in range(1, 7)]
        monitor(f"{folder}/{env}.monitor.csv", [paid + env + it for it in range(6)], started=started, at=ends)


def test_what_lies_below_the_folder_of_such_a_training_is_its_own(monitor, sort, tmp_path):
    """The table of progress that stable-baselines3's logger wrote beside the files of the environments."""
    for name in ("base", "arp"):
        batch(monitor, name, paid=len(name))
        (tmp_path / name / "log").mkdir()
        table = "rollout/ep_rew_mean,time/total_timesteps\n1.0,10\n2.0,20\n"
        (tmp_path / name / "log/progress.csv").write_text(table)
    found = sort()
    assert keys(found) == [("base", 0, 3), ("arp", 0, 3)]
    assert "Left out: 2 of table of points" in found.notes[-1]


def test_a_copy_of_an_environments_file_counts_once(monitor, sort, tmp_path):
    """It is no further environment: steps and episodes would count twice."""
    batch(monitor, "base", paid=1)
    (tmp_path / "base/3.monitor.csv").write_bytes((tmp_path / "base/0.monitor.csv").read_bytes())
    assert keys(sort()) == [("base", 0, 3)]


def test_files_that_were_begun_at_other_times_are_trainings(monitor, sort):
    """One after the other: no batch of environments was made over hours. Which of two numbers is the seed is asked."""
    for number, name in enumerate(("base_1", "base_2")):
        for seed in range(2):
            monitor(f"{name}/{seed}.monitor.csv", [number, seed, 1], started=1e9 + 1e4 * seed)
    with pytest.raises(UsageError, match="two numbers may be the seed") as asked:
        sort()
    assert sorts_of(asked.value) == ["base_{reward}/{seed}", "base_{seed}/{reward}"]
    assert keys(sort("base_{reward}/{seed}")) == [(name, seed, 1) for name in "12" for seed in range(2)]


def test_one_training_of_a_reward_is_asked_unless_it_was_named(tmp_path):
    """Names that were mistaken look like that; whoever named the files knows what they are."""
    logs = [curve(tmp_path / f"{name}.csv") for name in ("base", "arp")]
    with pytest.raises(UsageError, match="one training alone of base and arp") as asked:
        require_several(tmp_path, sort_logs(tmp_path, logs))
    assert [keys(sort_logs(tmp_path, logs, it)) for it in sorts_of(asked.value)] == [[("base", 0, 1), ("arp", 0, 1)]]


def test_a_doubtful_folder_is_read_as_those_beside_it(monitor, sort):
    """A training that broke off wrote few episodes; the same program wrote the other folder."""
    batch(monitor, "base", paid=1)
    for env in range(2):
        monitor(f"arp/{env}.monitor.csv", [env, 1], at=[1.0, 2.0])
    assert keys(sort()) == [("base", 0, 3), ("arp", 0, 2)]


def test_files_of_one_folder_have_its_name(monitor, sort, tmp_path):
    """Where the folder of a reward itself is named, templates fit as they do from above."""
    for seed in range(2):
        monitor(f"{seed}.monitor.csv", [seed, 1, 3])
    assert keys(sort("{reward}/{seed}")) == [(tmp_path.name, 0, 1), (tmp_path.name, 1, 1)]
    assert keys(sort("{reward}")) == [(tmp_path.name, 0, 2)]


def test_a_training_and_its_evaluations_are_one(monitor, sort, tmp_path):
    """A tree of the RL zoo: Monitor files of environments, and ``evaluations.npz`` beside them."""
    for seed in (1, 2):
        batch(monitor, f"ppo/Toy-v0_{seed}", paid=seed, envs=2, started=1.7e9 + 1e4 * seed)
        file = tmp_path / f"ppo/Toy-v0_{seed}/evaluations.npz"
        np.savez(file, timesteps=[10, 20], results=[[1.0, 2.0], [3.0, seed]], ep_lengths=[[5, 5], [5, 5]])
    found = sort()
    assert keys(found) == [("Toy-v0", 1, 2), ("Toy-v0", 2, 2)]
    assert [it.evaluation.facts.path.parent.name for it in found.trainings] == ["Toy-v0_1", "Toy-v0_2"]


def test_two_evaluations_of_one_training_are_asked_about(monitor, sort, tmp_path):
    """None counts because it is called so; a copy is no second one."""
    for name in ("a", "b"):
        for seed in (1, 2):
            monitor(f"base_{seed}/monitor.csv", [seed, 1, 3], started=1e9 + 1e4 * seed)
            (tmp_path / f"base_{seed}" / name).mkdir()
            file = tmp_path / f"base_{seed}/{name}/evaluations.npz"
            np.savez(file, timesteps=[10, 20], results=[[1.0, 2.0], [3.0, seed]])
    assert [it.evaluation.facts.path.parent.name for it in sort().trainings] == ["a", "a"]
    np.savez(file, timesteps=[10, 20], results=[[1.0, 2.0], [3.0, 7.0]])
    with pytest.raises(UsageError, match=r"'base_2/a' and 'base_2/b' say .* base was trained with seed 2: --leave-out"):
        sort()


def test_monitor_files_of_evaluations_are_left_out(monitor, sort):
    """Their steps are those of the environment that evaluated, and not of the training; that is told."""
    for seed in range(2):
        monitor(f"base/seed_{seed}/monitor.csv", [seed, 1, 3], started=1e9 + 1e4 * seed)
        monitor(f"base/seed_{seed}/eval/monitor.csv", [seed, 1, 4], started=1e9 + 1e4 * seed)
        monitor(f"base/seed_{seed}/eval.monitor.csv", [seed, 1, 5], started=1e9 + 1e4 * seed)
    found = sort()
    assert keys(found) == [("base", 0, 1), ("base", 1, 1)]
    assert found.notes[0].startswith("Left out: 4 of Monitor that are called evaluations")


def test_the_finest_log_of_a_training_is_read(monitor, tmp_path, sort):
    """Episodes tell more than the points of the same training; what is left out is told."""
    logs = []
    for seed in range(2):
        monitor(f"base_{seed}/monitor.csv", [seed, 1, 3])
        logs.append(curve(tmp_path / f"base_{seed}/PPO_1"))
    found = sort_logs(tmp_path, [*logs, *(log for it in sort().trainings for log in it.logs)])
    assert {log.facts.unit for it in found.trainings for log in it.logs} == {"episode"}
    assert "Left out: 2 of TensorBoard" in found.notes[-1]


def test_a_log_of_success_comes_before_a_finer_one(tmp_path, monitor, sort):
    """Monitor without success beside points that tell it: the points are read."""
    monitor("base_0/monitor.csv")
    points = curve(tmp_path / "base_0/PPO_1").add({"behaviour/success": np.array([0.0, 0.5, 1.0])})
    found = sort_logs(tmp_path, [points, *sort().trainings[0].logs])
    assert [log.facts.unit for log in found.trainings[0].logs] == ["point"]


def test_what_a_log_tells_itself_counts_more_than_its_name(tmp_path):
    """A reward and a seed in the log are believed, whatever the file is called."""
    logs = [curve(tmp_path / f"x{number}", trained_with="arp", seed=7 - number) for number in range(2)]
    assert keys(sort_logs(tmp_path, logs)) == [("arp", 6, 1), ("arp", 7, 1)]


def test_the_beginning_of_a_training_is_a_copy(tmp_path):
    """It lacks the last points, and would count twice; of few values an equal beginning may be chance."""
    points = np.sqrt(np.arange(8.0))
    logs = [
        in_memory(
            curve(tmp_path / f"{name}.csv").facts,
            {"time": np.arange(float(count)), "reward/recorded": points[:count]},
        )
        for name, count in (("base_0", 8), ("base_1", 6), ("base_2", 4), ("prop_0", 7))
    ]
    found = sort_logs(tmp_path, logs)
    assert keys(found) == [("base", 0, 1), ("base", 2, 1), ("prop", 0, 1)]
    assert "base_1.csv' is the beginning of " in found.notes[0]
    assert found.notes[1].endswith("base_0.csv', though one is of prop and one of base")


def test_trainings_without_a_seed_are_numbered(monitor, sort):
    """In the order of their names, and that is told."""
    for name in ("one", "two"):
        monitor(f"base/{name}.monitor.csv", [len(name), ord(name[0]), 3])
    found = sort("{reward}/*")
    assert keys(found) == [("base", 0, 1), ("base", 1, 1)]
    assert found.notes == ("2 of 2 trainings tell no seed: numbered in the order of their names",)
