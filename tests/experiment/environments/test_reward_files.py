"""Files of functions as rewards and measures of an environment: planned, trained, compared, and paid again later."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

import harness
from harness import load_registry, load_results
from harness.experiment.plan import check_experiment, expand
from harness.experiment.verify import verify
from harness.record import Store, read_recording
from harness.registry import read_given
from tests.refusals import refused

PENDULUM = "gymnasium:id=Pendulum-v1"
CALM = """
import _scale


def calm(observation, action, next_observation, info):
    return float(next_observation[0] - _scale.SPEED * abs(next_observation[2]))
"""
UPRIGHT = "def upright(observation, action, next_observation, info):\n    return float(next_observation[0] > 0.95)\n"
CRASHES = """
class crashes:
    episodes, was_asked = 0, False

    def reset(self):
        self.episodes, self.was_asked = self.episodes + self.was_asked, False

    def __call__(self, observation, action, next_observation, info):
        self.was_asked = True
        return 1 / (1 - self.episodes)
"""
BEHAVIOUR = """
lower_is_better = ["effort"]
higher_is_better = ["height"]


def height(observation, action, next_observation, info):
    return float(next_observation[0])


class effort:
    def reset(self):
        self.sum = 0.0

    def __call__(self, observation, action, next_observation, info):
        self.sum += abs(float(action[0]))
        return self.sum
"""
SHORT = {"task": PENDULUM, "algo": "random", "steps": 20, "evaluation_episodes": 1, "jobs": 1, "seeds": 1}
LATER = "def later(observation, action, next_observation, info):\n    return -abs(float(next_observation[2]))\n"


def _lay(folder, **files):
    folder.mkdir(exist_ok=True)
    for name, text in files.items():
        (folder / f"{name}.py").write_text(text)
    return folder


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """A folder of reward files: two that work, one that crashes, one that is broken; and what measures behaviour."""
    folder = tmp_path_factory.mktemp("files") / "rewards"
    return _lay(
        folder, calm=CALM, upright=UPRIGHT, crashes=CRASHES, broken="def (", behaviour=BEHAVIOUR, _scale="SPEED = 0.1"
    )


@pytest.fixture(scope="module")
def trained(files, tmp_path_factory):
    """An experiment with them."""
    folder = tmp_path_factory.mktemp("trained") / "runs"
    harness.run(
        task=PENDULUM, algo="random", plugins=[files / "*.py"], seeds=2, steps=210, evaluation_episodes=1, out=folder,
        jobs=1,
    )  # fmt: skip
    return folder


def plan_of(*paths, measures=(), **keys):
    """What is asked for of a pendulum with these files."""
    asked = {"task": PENDULUM, "algo": "random", "seeds": 1, "steps": 10, **keys}
    return expand(check_experiment(asked), load_registry(given=read_given(paths, measures)))


def test_every_file_is_a_reward_beside_the_environments_own(files):
    """That is the baseline. What could not be loaded is told before anything is trained."""
    plan = plan_of(files / "*.py")
    assert (plan.baseline, [cell.reward.label for cell in plan.cells]) == ("own", ["own", "calm", "crashes", "upright"])
    (line,) = plan.warnings
    assert line.startswith("Left out: Plugin file")
    assert [Path(it["path"]).name for it in plan.resolved["plugins"]] == [
        "behaviour.py", "calm.py", "crashes.py", "upright.py",
    ]  # fmt: skip


def test_rewards_may_be_chosen(files):
    """By their names."""
    plan = plan_of(files / "*.py", reward=["upright"], baseline="calm")
    assert [cell.reward.label for cell in plan.cells] == ["calm", "upright"]


def test_plan_without_a_measure_says_what_the_report_cannot_tell(files):
    """And what to give."""
    (line,) = plan_of(files / "calm.py").warnings
    assert "cannot say whether it behaves better" in line
    assert "--measure behaviour.py" in line
    assert not plan_of(files / "calm.py", measures=(files / "behaviour.py",)).warnings


@pytest.mark.parametrize(
    ("keys", "told"),
    [
        ({"measure": ["hight"]}, "No measure 'hight'. There is: effort, height. Did you mean 'height'?"),
        (
            {"measure": ["height"], "task": "fd100-reach", "sim": "kinematic"},
            "behaviour.py: the measure 'height' takes (observation, action, next_observation, info), as in environm",
        ),
        ({"reward": ["calmer"]}, "No reward 'calmer'. There is: calm, own. Did you mean 'calm'?"),
    ],
)
def test_what_is_not_known_is_refused(files, keys, told):
    """In one line."""
    with refused(re.escape(told)):
        plan_of(files / "calm.py", files / "behaviour.py", **keys)


def test_file_of_the_name_of_the_environments_own_reward_is_refused(tmp_path):
    """One of the two would not be told from the other."""
    _lay(tmp_path, own=UPRIGHT)
    with refused(r"own\.py': the environment has a reward 'own' of its own\. Rename yours"):
        plan_of(tmp_path / "own.py")


def test_crash_costs_only_the_cells_that_it_pays(trained):
    """If the trial did not see it. All others are done, recorded by every reward, and say what was given up."""
    results = load_results(trained)
    assert {(it.cell.reward.label, it.status) for it in results.manifests} == {
        ("own", "done"), ("calm", "done"), ("upright", "done"), ("crashes", "failed"),
    }  # fmt: skip
    for manifest in results.done:
        given_up, remembers = manifest.note.split("; ")
        told = "reward crashes given up in the training, episode 1, step 0: ZeroDivisionError: division by zero"
        assert given_up == told
        assert remembers.startswith("reward 'crashes': it remembers something beyond reset()")
        training = read_recording(results.store.cell_folder(manifest.cell) / "training")
        assert list(training.rewards) == ["own", "calm", "crashes", "upright"]
        assert not np.isnan(training["reward/calm"]).any()


def test_first_measure_of_the_file_decides_or_the_named_one(files, tmp_path):
    """None is called success. The same cells are not trained again; the file says of which less is better."""
    given = {"task": PENDULUM, "algo": "random", "seeds": 2, "steps": 200, "evaluation_episodes": 1, "jobs": 1}
    plugins = [files / "calm.py", files / "behaviour.py"]
    for measure, measures in (((), ("height", "effort")), (["effort"], ("effort", "height"))):
        results = harness.run(**given, plugins=plugins, measure=measure, out=tmp_path / "runs")
        measured = results.combinations[0].measured
        assert (measured.deciding, results.measures) == (measures[:1], measures)
        assert {it.measure.better for it in measured.changes if it.name == "effort"} == {"lower"}
    assert len(Store.open(tmp_path / "runs").read_plan().cells) == 4


def test_edit_of_a_file_beside_is_noticed(tmp_path):
    """Done cells that the reward trained are not mixed with new ones; those of others stay."""
    folder = _lay(tmp_path / "rewards", calm=CALM, _scale="SPEED = 0.1")
    harness.run(**SHORT, plugins=[folder / "calm.py"], out=tmp_path / "runs")
    _lay(folder, _scale="SPEED = 0.2")
    with refused(r"1 done cell was made by another reward calm \("):
        harness.run(**SHORT, plugins=[folder / "calm.py"], out=tmp_path / "runs")


def test_measures_that_are_gone_are_noticed(files, tmp_path):
    """New cells would lack what decides."""
    harness.run(**SHORT, reward=[], plugins=[files / "behaviour.py"], out=tmp_path / "runs")
    with refused(r"another measure height \(\w{8}, now none\)"):
        harness.run(**SHORT, reward=[], out=tmp_path / "runs")


@pytest.fixture
def later(tmp_path):
    """Of a file with a reward that was written later."""
    return "--plugin", _lay(tmp_path, later=LATER) / "later.py"


def test_later_file_pays_the_old_recordings(trained, later, say):
    """Trainings and evaluations, by taking their actions again. Then the report has it, and nothing is damaged."""
    status, told, _ = say("score", trained, *later)
    assert (status, told.count("210 steps by later"), told.count("200 steps by later")) == (0, 6, 13)
    for manifest in load_results(trained).done:
        for part in ("training", "evaluation"):
            recording = read_recording(Store.open(trained).cell_folder(manifest.cell) / part)
            assert -8.0 <= recording["reward/later"].min() < recording["reward/later"].max() <= 0.0
    assert not verify(trained)
    assert "later  " in say("report", trained)[1]
    assert say("score", trained, *later)[1].count("nothing to do") == 19


def test_later_measure_measures_the_old_recordings(trained, tmp_path, say):
    """As it would have at once."""
    _lay(tmp_path, behaviour=BEHAVIOUR.replace("height", "tip").replace("effort", "work"))
    assert say("score", trained, "--plugin", tmp_path / "behaviour.py")[0] == 0
    cell = next(it.cell for it in load_results(trained).done)
    recording = read_recording(Store.open(trained).cell_folder(cell) / "training")
    assert np.array_equal(recording["behaviour/tip"], recording["behaviour/height"])
    assert np.array_equal(recording["behaviour/work"], recording["behaviour/effort"])
    assert recording.facts.lower_is_better == ("effort", "work")


def test_other_code_of_a_reward_that_trained_is_refused(trained, tmp_path, say):
    """Nothing is written: two rewards would have one name."""
    _lay(tmp_path, upright=UPRIGHT.replace("0.95", "0.5"))
    status, _, told = say("score", trained, "--plugin", tmp_path / "upright.py")
    assert status == 2
    assert "The reward 'upright' trained" in told
    assert "give the new one another name" in told


def test_mended_file_pays_what_it_could_not(trained, files, tmp_path, say):
    """It had trained nothing, since its cells failed."""
    _lay(tmp_path, crashes=CRASHES.replace("1 / (1 - self.episodes)", "0.5"))
    assert say("score", trained, "--plugin", tmp_path / "crashes.py")[0] == 0
    cell = next(it.cell for it in load_results(trained).done)
    assert set(read_recording(Store.open(trained).cell_folder(cell) / "training")["reward/crashes"]) == {0.5}


def _loose(folder):
    import gymnasium

    env = harness.RecordRewards(gymnasium.make("Pendulum-v1"), folder / "own-0", trained_with="own", rewards={})
    env.reset(seed=0)
    for _ in range(20):
        env.step(np.array([0.5], np.float32))
    env.close()
    return folder


def test_later_file_pays_loose_recordings(tmp_path, later, say):
    """In the env of the id in the recording."""
    status, told, _ = say("score", _loose(tmp_path / "runs"), *later, "--json")
    assert status == 0
    assert json.loads(told)["recordings"] == [
        {"folder": f"{tmp_path}/runs/own-0", "names": ["later"], "steps": 20, "failed": [], "refused": ""}
    ]


def test_loose_recording_is_paid_in_the_environment_that_is_named(tmp_path, later, say):
    """Another one answers otherwise, and pays nothing."""
    runs = _loose(tmp_path / "runs")
    status, told, _ = say("score", runs, *later, "--task", f"{PENDULUM},made_with=g=9.0")
    assert (status, "does not answer as it did" in told) == (1, True)
    assert say("score", runs, *later, "--task", PENDULUM)[0] == 0


def test_id_in_a_recording_imports_nothing(tmp_path, later, say):
    """A folder may come from anybody."""
    runs = _loose(tmp_path / "runs")
    from dataclasses import replace

    from harness.record import TrainingFacts

    path = runs / "own-0" / "recording-0.json"
    facts = TrainingFacts.read(path)
    replace(facts, spec={**facts.spec, "id": "antigravity:Pendulum-v1"}).write(path)
    status, told, _ = say("score", runs, *later)
    assert (status, "which Gymnasium cannot make by itself. Name an environment" in told) == (1, True)


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ((), "No reward is given: name a file of functions with --plugin"),
        (("--reward", "nothing"), "No reward or measure 'nothing'"),
        (("--task", PENDULUM), "--task does not go with an experiment"),
    ],
)
def test_what_cannot_be_scored_is_refused(trained, later, say, arguments, told):
    """With what to give."""
    plugin = later if arguments else ()
    status, _, err = say("score", trained, *plugin, *arguments)
    assert status == 2
    assert told in err
