"""Sixty ways in which people name trainings. What names cannot tell is asked."""

import base64
import hashlib
import uuid
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, strategies as st

from harness.errors import UsageError
from harness.log import LogFacts, in_memory
from harness.results.logs.trainings import require_several, sort_files, sort_logs
from tests.results.logs.conftest import sorts_of

WAYS = """
{reward}/{seed}/progress.csv                                        | base prop            | 0 1 2       | seed
{reward}_{seed}/progress.csv                                        | base prop            | 0 1 2       | seed
{reward}{seed}.csv                                                  | base prop            | 1 2 3       | seed
{reward}-s{seed}/progress.csv                                       | base prop            | 1 2 3       | seed
{reward}_seed{seed}.monitor.csv                                     | base prop            | 0 1 2       | seed
{reward}.seed{seed}.csv                                             | base prop            | 1 2 3       | seed
{reward} seed {seed}/progress.csv                                   | base prop            | 1 2 3       | seed
reward={reward}/seed={seed}/progress.csv                            | base prop            | 0 1 2       | seed
seed_{seed}/{reward}/progress.csv                                   | base prop            | 0 1 2       | seed
seed{seed}/{reward}.csv                                             | base prop            | 0 1 2       | seed
{seed}/{reward}/progress.csv                                        | base prop            | 0 1 2       | seed
s{seed}_{reward}.csv                                                | base prop            | 0 1 2       | seed
{seed}_{reward}.csv                                                 | base prop            | 0 1 2       | seed
{reward}_{seed:03d}/progress.csv                                    | base prop            | 8 9 10      | seed
{reward}/run_{seed}/progress.csv                                    | base prop            | 1 2 3       | seed
{reward}_rep{seed}.csv                                              | base prop            | 1 2 3       | seed
{reward}/trial-{seed}/progress.csv                                  | base prop            | 0 1 2       | seed
{reward}/{seed}/progress.csv                                        | base prop            | 42 123 1337 | seed
{reward}_{seed}/progress.csv                                        | base base_shaped     | 0 1 2       | seed
exp3/results/{reward}/PPO/seed_{seed}/logs/progress.csv             | base prop            | 0 1 2       | seed
{reward}_envs8_{seed}_1000000.csv                                   | base prop            | 0 1 2       | seed
HalfCheetah-v4_{reward}_{seed}/progress.csv                         | base prop            | 0 1 2       | seed
tb/{reward}_{seed}/PPO_1/progress.csv                               | base prop            | 0 1 2       | seed
tb/{reward}/PPO_{seed}/progress.csv                                 | base prop            | 1 2 3       | seed
{reward}/ppo/Reach-v1_{seed}/evaluations.npz                        | base prop            | 1 2 3       | seed
ppo/{reward}-v1_{seed}/progress.csv                                 | ReachDense ReachFar  | 1 2 3       | seed
Reach-v1__ppo_{reward}__{seed}__17000{run:05d}/progress.csv         | base prop            | 1 2 3       | seed
{reward}-v1__ppo__{seed}__17000{run:05d}/progress.csv               | Reach ReachShaped    | 1 2 3       | seed
PPO_env_0a1b2_{run:05d}_{run}_reward={reward},seed={seed}_2026-01-01_10-00-{run:02d}/progress.csv|base prop|0 1 2|seed
PPO_env_0a1b2_{run:05d}_{run}_lr={reward},seed={seed}_2026-01-01_10-00-{run:02d}/progress.csv|0.001 0.01|0 1 2|seed
{reward}/PPO_Reach_0a1b2_{run:05d}_{run}_2026-01-01_10-00-{run:02d}/progress.csv | base prop    | 0 1 2   | reward
multirun/2026-01-01/10-00-00/{run}/progress.csv                     | 10-00-00             | 0 1 2 3     | reward
multirun/2026-01-01/10-00-00/reward={reward},seed={seed}/progress.csv | base prop          | 0 1 2       | seed
{reward}/2026-01-01/10-00-{run:02d}/progress.csv                    | base prop            | 0 1 2       | reward
2024-05-01_{reward}_{seed}.csv                                      | base prop            | 0 1 2       | seed
{reward}_20240501-1020{run:02d}_seed{seed}/progress.csv             | base prop            | 0 1 2       | seed
2405{run1:02d}_{reward}_{seed}/progress.csv                         | base prop            | 0 1 2       | seed
runs/May01_10-20-{run:02d}_titan{reward}/progress.csv               | -base -prop          | 0 1 2       | reward
rsl_rl/reach/2024-05-01_10-20-{run:02d}_{reward}/progress.csv       | base prop            | 0 1 2       | reward
{reward}_20240501102{run:03d}/progress.csv                          | base prop            | 0 1 2       | reward
gpu{even}_{reward}_seed{seed}/progress.csv                          | base prop            | 0 1 2 3     | seed
cuda:{even}/{reward}/{seed}/progress.csv                            | base prop            | 0 1 2 3     | seed
node0{even}/{reward}/seed_{seed}/progress.csv                       | base prop            | 0 1 2 3     | seed
{host}/{reward}_{seed}/progress.csv                                 | base prop            | 0 1 2 3     | asked
{reward}/job_123456_{seed}/progress.csv                             | base prop            | 0 1 2       | seed
{reward}_job{id}/progress.csv                                       | base prop            | 0 1 2       | reward
{reward}_{letter}/progress.csv                                      | base prop            | 0 1 2       | asked
{reward}/{wandb}-{run}/progress.csv                                 | base prop            | 0 1 2       | asked
{wandb}-{run}.csv                                                   | base prop            | 0 1 2       | asked
{reward}/wandb/run-20240501_1020{run:02d}-{letters}/files/progress.csv | base prop            | 0 1 2       | reward
{reward}/{uuid}/progress.csv                                        | base prop            | 0 1 2       | reward
ppo_{reward}_{hash}/progress.csv                                    | base prop            | 0 1 2       | reward
{reward}_seed{seed}/progress.csv                                    | w0.5 w1.0 w2.0       | 0 1 2       | seed
{reward}_{seed}.csv                    | base_lr1e-3 base_lr3e-4 prop_lr1e-3 prop_lr3e-4   | 0 1 2       | seed
{reward}_seed{seed}/progress.csv                                    | penalty1 penalty10   | 0 1 2       | seed
{seed}/{reward}/progress.csv                                        | penalty0 penalty10 penalty100 | 0 1 2 | asked
{reward}_{seed}/progress.csv                                        | run1 run2 run3       | 0 1 2       | asked
w{reward}/{seed}/progress.csv                                       | 1 2 5                | 0 1 2       | asked
{reward}_{tens}.csv                                                 | base weight          | 0 1 2 3     | asked
{reward}/seed_{seed}/run_{even}/progress.csv                        | base prop            | 0 0 1 1     | asked
"""
"""A row each: how names are made, the rewards, the seeds of each, and what is right. ``seed``: both are told;
``reward``: no seed is; ``asked``: names can be read in two ways."""
HOSTS, LETTERS = ("titan", "atlas"), "abcdef"
WANDB = ("fluent-sunset", "glad-moon", "calm-river", "dry-cloud", "wild-fire", "azure-hill")


class Way(NamedTuple):
    names: dict[str, tuple[str, int]]
    """By path the reward and the seed."""
    right: str


def way_of(line):
    """The names of a row of the table."""
    pattern, rewards, seeds, right = (part.strip() for part in line.split("|"))
    names = {}
    for reward in rewards.split():
        for place, seed in enumerate(map(int, seeds.split())):
            run = len(names)
            digest = hashlib.sha1(f"{line}{run}".encode()).hexdigest()
            name = pattern.format(
                reward=reward,
                seed=seed,
                run=run,
                run1=run + 1,
                even=place % 2,
                host=HOSTS[place // 2 % 2],
                letter=LETTERS[place],
                wandb=WANDB[run % 6],
                hash=digest[:8],
                uuid=uuid.UUID(digest[:32]),
                id=8391 + 3 * run,
                letters=base64.b32encode(digest.encode())[8:16].decode().lower(),
                tens=10 * (seed + 1) if reward == "weight" else seed,
            )
            names[name] = reward, seed
    return Way(names, right)


ALL = [way_of(line) for line in WAYS.strip().splitlines()]


def log_of(path):
    """Three points that no other path has."""
    values = np.frombuffer(hashlib.sha256(str(path.name + path.parent.as_posix()).encode()).digest()[:24], np.uint64)
    facts = LogFacts(path=path, format="table", unit="point")
    return in_memory(facts, {"time": np.array([10.0, 20.0, 30.0]), "reward/recorded": values.astype(float)})


def sorted_names(folder, names):
    """By name the reward and the seed; None where it is asked, as where one training of a reward is alone."""
    try:
        found = sort_logs(folder, [log_of(folder / name) for name in names])
        require_several(folder, found)
    except UsageError:
        return None
    return {it.path.relative_to(folder).as_posix(): (it.reward, it.seed) for it in found.trainings}


def groups_of(named):
    """The names of each reward together."""
    return {frozenset(it for it in named if named[it][0] == reward) for reward, _ in named.values()}


def judged(way, folder):
    """What is said of a way: ``right``, ``asked``, or ``wrong``."""
    found = sorted_names(folder, way.names)
    if found is None:
        return "asked"
    has_seeds = {name: seed for name, (_, seed) in found.items()} == {name: it for name, (_, it) in way.names.items()}
    is_right = groups_of(found) == groups_of(way.names) and (has_seeds or way.right == "reward")
    return "right" if is_right and way.right != "asked" else "wrong"


@pytest.mark.parametrize("line", WAYS.strip().splitlines())
def test_a_way_of_naming_is_read_or_asked(line, tmp_path):
    """What one can tell by names is told, and nothing else."""
    way = way_of(line)
    assert judged(way, tmp_path) == ("asked" if way.right == "asked" else "right")


@pytest.mark.parametrize(
    ("line", "rewards"),
    [
        ("{seed}/{reward}/monitor.csv | penalty0 penalty1 penalty10 penalty100 | 0 1 2 3 4 | asked", 4),
        ("{reward}_{seed}/monitor.csv | run1 run2 run3 run4 run5 run6 | 0 1 2 3 4 | asked", 6),
        ("{reward}_{tens}.csv | base weight | 0 1 2 3 | asked", 2),
        ("{host}/{reward}_{seed}/progress.csv | base prop | 0 1 2 3 | asked", 2),
        ("node/{reward}/{seed}/seed_{even}.csv | base prop | 0 1 2 3 | asked", 2),
    ],
)
def test_each_template_that_is_asked_for_sorts(line, rewards, tmp_path):
    """Typed as it stands each says which trainings there are, and one of them is right."""
    way = way_of(line)
    logs = [log_of(tmp_path / name) for name in way.names]
    with pytest.raises(UsageError, match="Names such as") as asked:
        require_several(tmp_path, sort_logs(tmp_path, logs))
    found = [sort_logs(tmp_path, logs, template) for template in sorts_of(asked.value)]
    assert len(found) > 1
    assert {len(it.trainings) for it in found} == {len(logs)}
    assert rewards in {len(it.rewards) for it in found}


CLEAR = [way for way in ALL if way.right == "seed"]


@given(st.data())
def test_names_sort_alike_wherever_they_lie(data):
    """In any order, in another folder and with other words for rewards, the sorting is the same."""
    way = data.draw(st.sampled_from(CLEAR))
    old = sorted({reward for reward, _ in way.names.values()})
    words = ["gentle", "dense", "far", "x_shaped"]
    is_word = all(it.isalpha() for it in old)
    new = dict(zip(old, data.draw(st.permutations(words)) if is_word else old, strict=False))
    place = data.draw(st.sampled_from(["", "runs/", "a-long/way_down/", "2024-05-01/"]))
    named = {
        place + name.replace(reward, new[reward]): (new[reward], seed) for name, (reward, seed) in way.names.items()
    }
    found = sorted_names(Path("/nowhere/logs"), data.draw(st.permutations(list(named))))
    assert found is None or {name: seed for name, (_, seed) in found.items()} == {
        name: seed for name, (_, seed) in named.items()
    }
    assert found is None or groups_of(found) == groups_of(named)


WORDS = "base prop seed run 0 1 7 10 007 w0.5 1e-3 gpu1 2024-05-01 3f2a91c env_0 * | {reward} {seed} (1) é"
NAMES = st.lists(
    st.lists(st.sampled_from(WORDS.split()), min_size=3, max_size=3), min_size=1, max_size=6, unique_by=tuple
)


@given(NAMES, st.sampled_from(["{}_{}_{}.csv", "{}/{}-{}.csv", "{}/{}/{}.csv", "{}{}={}.csv"]))
def test_any_names_are_sorted_or_asked_by_templates_that_fit(names, pattern):
    """Whatever stands in them, also what looks like a template; and each that is printed can be typed."""
    files = [Path("/nowhere/logs", pattern.format(*words)) for words in names]
    try:
        sort_files(Path("/nowhere/logs"), files)
    except UsageError as asked:
        for template in sorts_of(asked):
            assert sort_files(Path("/nowhere/logs"), files, template)


@given(st.sampled_from(CLEAR), st.data())
def test_files_that_were_split_into_folders_sort_alike_or_are_asked(way, data):
    """A folder that holds some of the trainings is no reward."""
    part = {name: data.draw(st.sampled_from(["a", "b"])) for name in way.names}
    found = sorted_names(Path("/nowhere/logs"), [f"{part[name]}/{name}" for name in way.names])
    assert found is None or groups_of(found) == groups_of({f"{part[it]}/{it}": of for it, of in way.names.items()})


EXACT = """
{reward}/{seed}.csv               | v1 v2            | 0 1 | seed
{reward}_{seed}.csv               | k1 k2            | 0 1 | seed
{reward}_{seed}.csv               | base p:k2=0.5    | 1 2 | seed
{reward}{seed}.csv                | base base_shaped | 1 2 | seed
ppo/{reward}_{seed}.csv           | Pendulum-v1      | 1 2 | seed
{reward}/2024050{run1}-12{run1}0.csv | base             | 0 1 | seed
"""


@pytest.mark.parametrize("line", EXACT.strip().splitlines())
def test_what_is_a_seed_and_what_is_not(line, tmp_path):
    """Versions, decimal numbers and numbers that all share belong to the reward, or to nothing."""
    way = way_of(line)
    assert sorted_names(tmp_path, way.names) == way.names


@pytest.mark.parametrize(
    ("names", "rewards", "seeds"),
    [
        (
            ["2024-05-01-baseline_1", "2024-05-01-baseline_2", "2024-05-01-shaped22_1"],
            ["baseline"] * 2 + ["shaped22"],
            [1, 2, 1],
        ),
        (["base_0", "base_1", "prop_7", "prop_0"], ["base", "base", "prop", "prop"], [0, 1, 0, 7]),
    ],
)
def test_rewards_may_have_other_seeds(names, rewards, seeds, tmp_path):
    """And other numbers of them."""
    found = sort_logs(tmp_path, [log_of(tmp_path / f"{name}.csv") for name in names])
    assert [(it.reward, it.seed) for it in found.trainings] == list(zip(rewards, seeds, strict=True))


@pytest.mark.parametrize(
    ("template", "name", "reward", "seed"),
    [
        ("{reward}/{seed}", "runs/base/3", "base", 3),
        ("*_{reward}_s{seed}", "x_base_s3/deep/monitor", "base", 3),
        ("{reward}_{seed}", "my_base_v2_1", "my_base_v2", 1),
        ("{reward}", "base/1", "base", 0),
        ("{reward}/*", "base/1", "base", 0),
    ],
)
def test_a_template_says_how_names_are_made(template, name, reward, seed, tmp_path):
    """The reward, and the seed."""
    (found,) = sort_logs(tmp_path, [log_of(tmp_path / f"{name}.csv")], template).trainings
    assert (found.reward, found.seed) == (reward, seed)


@pytest.mark.parametrize("template", ["{seed}", "{reward}/{seed}/{seed}", "{reward}-{seed}"])
def test_a_template_that_cannot_say_it_is_refused(template, tmp_path):
    """Without a reward, with two seeds, or of other names: the message shows the template."""
    with pytest.raises(UsageError, match="--sort"):
        sort_logs(tmp_path, [log_of(tmp_path / "base/0.csv")], template)
