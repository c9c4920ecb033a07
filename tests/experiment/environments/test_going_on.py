"""Cells in an environment that are killed go on from their last checkpoint, to the same end."""

import functools
import shutil

import pytest

from harness.executor import CellOptions
from harness.experiment.plan import check_experiment, expand
from harness.experiment.run_cell import run_cell
from harness.experiment.workers import order
from harness.record import LOG, MANIFEST, partial_folder, read_manifest
from harness.record.cell import digests_in
from harness.record.folder import evaluation_files

EVERY = 50
SMALL = "net_arch=8,batch_size=8,learning_starts=40"
RANDOM = "random:num_envs=2"
LEARNERS = {
    "sac-fast": f"sac-fast:{SMALL},buffer_size=90",
    "random, 2 envs": RANDOM,
    "sb3-sac": f"sb3-sac:{SMALL}",
    "her, 2 envs": f"her:{SMALL},num_envs=2",
    "ppo": "ppo:net_arch=8,batch_size=8,rollout=32,num_envs=1",
    "spg": "spg:net_arch=8,decisions=9,num_envs=2,restart=3",
    "dqn": f"dqn:{SMALL}",
}
CASES = [
    pytest.param(algo, marks=[pytest.mark.slow] * (name not in ("sac-fast", "random, 2 envs", "her, 2 envs")), id=name)
    for name, algo in LEARNERS.items()
]


def _cell(registry, algo=RANDOM, **keys):
    task = {"task": "toy:discrete=true"} if algo.startswith("dqn") else {"task": "goal_toy", "baseline": "there"}
    asked = {"algo": algo, "reward": [], "seeds": 1, "steps": 198, "evaluation_episodes": 3, **task, **keys}
    (cell,) = expand(check_experiment(asked), registry).cells
    return cell


def files_of(folder):
    """What a cell left, but for what tells of its times."""
    return {name: it for name, it in digests_in(folder).items() if name not in (LOG, MANIFEST)}


def _leave(cell, folder, given, until=198):
    """The partial folder of `folder`, as a process leaves it that is killed when it has told of `until` steps."""

    def report(word):
        if word.steps >= until and not partial_folder(folder).exists():
            shutil.copytree(partial_folder(folder.with_name("whole")), partial_folder(folder))

    run_cell(cell, folder.with_name("whole"), report, CellOptions(EVERY, plugins=given))
    assert partial_folder(folder).exists()


def _go_on(cell, folder, given, every=EVERY):
    return run_cell(cell, folder, lambda word: None, CellOptions(every, plugins=given))


@pytest.mark.parametrize("algo", CASES)
def test_a_killed_cell_ends_as_if_it_had_not_been(registry, given, tmp_path, algo):
    """Recordings and policy are, byte for byte, those of a cell that nobody killed and that left no checkpoints."""
    cell = _cell(registry, algo)
    _go_on(cell, tmp_path / "plain", given, every=0)
    _leave(cell, tmp_path / "killed", given)
    manifest = _go_on(cell, tmp_path / "killed", given)
    assert (manifest.status, manifest.note) == ("done", f"went on after {manifest.resumed_from} steps")
    assert manifest.resumed_from >= 100
    assert files_of(tmp_path / "killed") == files_of(tmp_path / "whole") == files_of(tmp_path / "plain")


def test_it_goes_on_twice(registry, given, tmp_path):
    """From a checkpoint of the process that went on, too."""
    cell = _cell(registry, steps=900)
    _go_on(cell, tmp_path / "plain", given, every=0)
    for name, until in (("once", 300), ("twice", 700)):
        _leave(cell, tmp_path / name / "killed", given, until)
        if name == "once":
            shutil.copytree(tmp_path / "once", tmp_path / "twice")
            shutil.rmtree(tmp_path / "twice" / "whole")
            partial_folder(tmp_path / "twice" / "killed").rename(partial_folder(tmp_path / "twice" / "whole"))
    assert 650 <= _go_on(cell, tmp_path / "twice" / "killed", given).resumed_from <= 800
    assert read_manifest(tmp_path / "twice" / "whole").resumed_from >= 250
    assert files_of(tmp_path / "twice" / "killed") == files_of(tmp_path / "plain")


def test_evaluations_on_the_way_are_not_made_again(registry, given, tmp_path):
    """Those before the checkpoint stay, the later ones are made again: the cell has what it would have had."""
    cell = _cell(registry, LEARNERS["sac-fast"], evaluate_every=60)
    _go_on(cell, tmp_path / "plain", given, every=0)
    _leave(cell, tmp_path / "killed", given)
    assert _go_on(cell, tmp_path / "killed", given).resumed_from >= 100
    assert list(evaluation_files(tmp_path / "killed", suffix="")) == [60, 120, 180]
    assert files_of(tmp_path / "killed") == files_of(tmp_path / "plain")


def test_a_cell_that_is_killed_in_its_evaluation_goes_on(registry, given, tmp_path, monkeypatch):
    """What it had evaluated is thrown away, with the policy: they come to be again."""
    monkeypatch.setattr(order, "EVERY", 0.0)
    cell, whole, killed = _cell(registry), tmp_path / "whole", tmp_path / "killed"

    def report(word):
        if (partial_folder(whole) / "evaluation").exists() and not partial_folder(killed).exists():
            shutil.copytree(partial_folder(whole), partial_folder(killed))

    run_cell(cell, whole, report, CellOptions(EVERY, plugins=given))
    assert (partial_folder(killed) / "evaluation").exists()
    assert _go_on(cell, killed, given).resumed_from == 150
    assert files_of(killed) == files_of(whole)


@pytest.mark.parametrize(
    ("answer", "told"),
    [
        (lambda step, action: step(0.99 * action), "did something else"),
        (lambda step, action: 1 / 0, "are repeated: ZeroDivisionError"),
    ],
)
def test_an_env_that_does_not_do_it_again_starts_over(registry, given, tmp_path, monkeypatch, answer, told):
    """What it does is compared with what it did; the note says why the cell was begun anew, which may go well."""
    cell = _cell(registry)
    _leave(cell, tmp_path / "killed", given)
    toy, made = registry.get("environments", "goal_toy").load(), []
    make = toy.make

    def other_at_first(self):
        env = make(self)
        made.append(env)
        if len(made) == 1:
            env.step = functools.partial(answer, env.step)
        return env

    monkeypatch.setattr(toy, "make", other_at_first)
    manifest = _go_on(cell, tmp_path / "killed", given)
    assert (manifest.status, manifest.resumed_from) == ("done", 0)
    assert told in manifest.note


def test_nothing_of_a_checkpoint_is_left(registry, given, tmp_path):
    """In the folder of a cell that is done; while it trains there is one, with the actions in files that grow."""
    _leave(_cell(registry), tmp_path / "killed", given)
    left = {path.name for path in partial_folder(tmp_path / "killed").iterdir()}
    assert {"checkpoint.safetensors", "training"} <= left
    assert sorted(name for name in left if name.startswith("ring.")) == [
        "ring.env%2Factions.0-25.safetensors",
        "ring.env%2Factions.25-50.safetensors",
        "ring.env%2Factions.50-75.safetensors",
    ]
    assert not {name for name in digests_in(tmp_path / "whole") if name.startswith(("ring", "checkpoint.safetensors"))}


def test_an_algorithm_that_resets_with_a_seed_leaves_no_checkpoint(registry, given, tmp_path, monkeypatch):
    """What it did could not be done again."""
    learner = registry.get("algorithms", "random").load()
    train = learner.train

    def seeds(self, env, *rest):
        env.reset(seed=3)
        return train(self, env, *rest)

    monkeypatch.setattr(learner, "train", seeds)
    _leave(_cell(registry, "random"), tmp_path / "killed", given)
    assert not (partial_folder(tmp_path / "killed") / "checkpoint.safetensors").exists()


@pytest.mark.slow
@pytest.mark.parametrize("algo", [LEARNERS["sac-fast"], LEARNERS["her, 2 envs"]])
def test_a_process_that_is_killed_loses_nothing(
    registry,
    given,
    tmp_path,
    train_in_a_process,
    algo,
):
    """By SIGKILL, twice, at any moment: afterwards every byte is that of an undisturbed cell."""
    cell = _cell(registry, algo, steps=1600)
    train_in_a_process(cell, tmp_path / "whole", 0, plugins=given)
    for until in (500, 1300):
        train_in_a_process(cell, tmp_path / "killed", 100, until, plugins=given)
        assert not (tmp_path / "killed").exists()
    train_in_a_process(cell, tmp_path / "killed", 100, plugins=given)
    assert read_manifest(tmp_path / "killed").resumed_from >= 1000
    assert files_of(tmp_path / "killed") == files_of(tmp_path / "whole")
