"""Functions of a step or of an episode in an arm's experiment: what is planned, recorded, shown and decided."""

import json

import pyarrow.parquet as pq
import pytest

import harness
from harness import load_registry, load_results
from harness.experiment.arm_world import evaluation_scalars
from harness.experiment.experiment import check
from harness.experiment.plan import check_experiment, expand
from harness.experiment.trials.arm_trial import try_arm
from harness.experiment.trials.tried import Tried
from harness.record import read_trace
from harness.registry import read_given
from harness.report import Report
from harness.report.document import report_text
from harness.results.metrics import fields_needed
from tests.refusals import refused

CALM = "def calm(step):\n    return abs(step.qvel).max(-1)\n"
NEAR = "def near(step):\n    return step.distance < 0.9\n"
SUCCESS = NEAR.replace("near", "success")
OLD = "def height(observation, action, next_observation, info):\n    return 1.0\n"
ARM = {"sim": "kinematic", "algo": "random", "reward": "arp", "steps": 100, "evaluation_episodes": 3}


@pytest.fixture(name="lay")
def _lay(tmp_path):
    def lay(source, name="behaviour.py"):
        (tmp_path / name).write_text(source)
        return load_registry(given=read_given((), [tmp_path / name]))

    return lay


def _plan(registry, **keys):
    return expand(check_experiment({**ARM, "seeds": 1, **keys}), registry)


def test_what_a_measure_reads_is_recorded(lay):
    """In every trace of the experiment, whose cells stay what they were."""
    with_speed, without = (_plan(lay(source)).cells for source in (CALM, NEAR))
    assert ({it.records for it in with_speed}, {it.records for it in without}) == ({("qvel",)}, {()})
    assert [it.id for it in with_speed] == [it.id for it in without]


def test_fields_that_measures_need_have_their_names(lay):
    """Those of others; metrics of our own ask for nothing."""
    assert fields_needed(lay(CALM)) == {"qvel"}
    assert fields_needed(load_registry()) == frozenset()


@pytest.mark.parametrize(
    ("source", "asked", "kept"),
    [
        (CALM + SUCCESS, [], ["success"]),
        (CALM + NEAR, ["near"], ["near"]),
        ("lower_is_better = ['calm']\n" + CALM + SUCCESS, ["calm"], ["calm"]),
        (CALM, ["work"], ["work"]),
        (CALM, [], None),
    ],
)
def test_experiment_keeps_what_decides(lay, source, asked, kept):
    """What is named, else a measure called success; else nothing, and success_rate decides as before."""
    assert _plan(lay(source), measure=asked).resolved.get("measure") == kept


def test_a_measure_decides_only_where_it_is_known_what_is_better(lay):
    """Else it is refused before anything is trained, with what to write; then it decides."""
    with refused(r"'calm' decides.*write lower_is_better = \['calm'\] or higher_is_better"):
        _plan(lay(CALM), measure=["calm"])
    assert _plan(lay("higher_is_better = ['calm']\n" + CALM), measure=["calm"]).resolved["measure"] == ["calm"]


def test_name_of_no_measure_is_refused(lay):
    """With the nearest."""
    with refused(r"No measure 'clam'\. .*Did you mean 'calm'\?"):
        _plan(lay(CALM), measure=["clam"])


def test_function_for_environments_is_told(lay):
    """It measures nothing here, and the run goes on."""
    (line,) = _plan(lay(OLD + CALM)).warnings
    assert line.startswith("behaviour.py: the measure 'height' takes (observation, action, next_observation, info)")
    assert line.endswith("Write height(step), or height(episode) of a whole episode")


def test_what_fails_on_made_up_steps_is_refused_in_the_plan(lay):
    """It reads what no step has."""
    with refused("Measure 'calm': A step of an arm has no 'speed'"):
        _plan(lay("def calm(step):\n    return step.speed"))


def _tried(registry, without=()):
    cell = _plan(registry).cells[0]
    return try_arm(cell, [cell.reward], registry, without, lambda column: None)


LONG = "def calm(episode):\n    return 1.0 / (len(episode.step) == 16)\n"


def test_what_fails_in_an_episode_is_a_fault(lay):
    """With the place in the file; the others are no fault."""
    (fault,) = _tried(lay(LONG + NEAR)).faults
    assert (fault.noun, fault.name) == ("measure", "calm")
    assert fault.reason.startswith("fails in an episode: ZeroDivisionError: ")
    assert "behaviour.py, line 2" in fault.reason


def test_what_ended_the_process_is_not_asked_again(lay):
    """By its column."""
    assert _tried(lay(LONG + NEAR), without=("behaviour_calm",)) == Tried()


def test_speeds_are_there_in_the_trial(lay):
    """A measure of them is asked."""
    assert _tried(lay(CALM)) == Tried()


def test_failing_measure_is_refused_before_a_run(lay, tmp_path):
    """With its file."""
    given = lay(LONG).given
    with refused(r"measure 'calm' \('.*behaviour\.py'\) fails in an episode"):
        check(check_experiment({**ARM, "seeds": 1}), given=given)


def test_whole_episodes_are_not_measured_in_environments(lay):
    """The refusal says what to write."""
    registry = lay("def wobble(episode):\n    return 1.0\n")
    asked = {"task": "gymnasium:id=CartPole-v1", "algo": "random", "reward": "own", "steps": 10, "seeds": 1}
    with refused(r"'wobble' takes \(episode\).*In an environment write wobble\(step\)"):
        expand(check_experiment(asked), registry)


@pytest.fixture(name="file", scope="module")
def _file(tmp_path_factory):
    path = tmp_path_factory.mktemp("mine") / "mine.py"
    path.write_text('lower_is_better = ["calm"]\nunits = {"calm": "rad/s"}\n' + CALM + NEAR)
    return path


@pytest.fixture(name="folder", scope="module")
def _folder(file, tmp_path_factory):
    """An experiment in which ``near`` decides."""
    out = tmp_path_factory.mktemp("experiment") / "R"
    asked = {**ARM, "sim": ["kinematic"], "algo": ["random"], "reward": ["arp"], "task": "fd100-reach:horizon=20"}
    harness.run(**asked, seeds=2, measure=["near", file], out=out, jobs=1)  # type: ignore[arg-type]
    return out


@pytest.fixture(name="results", scope="module")
def _results(folder, file):
    return load_results(folder, measures=[file])


def test_they_stand_among_the_metrics(results):
    """In the JSON, with unit and direction; one that is true or false as a share."""
    behaviour = json.loads(report_text(Report(results)))["combinations"][0]["behaviour"]
    told = {it["name"]: it for it in behaviour if it["manner"] == "deterministic"}
    assert (told["calm"]["unit"], told["calm"]["better"], told["calm"]["episodes"]) == ("rad/s", "lower", None)
    assert (told["near"]["better"], told["near"]["episodes"]) == ("higher", 3)
    assert told["calm"]["baseline"] > 0.0


def test_the_named_one_decides(results):
    """Alone."""
    (comparison,) = results.combinations
    assert comparison.measured.deciding == ("near",)
    assert [it.name for it in comparison.decisive_changes] == ["near", "near"]


def test_success_rate_decides_where_none_is_named(results, file, tmp_path):
    """The mutant: a measure alone changes no verdict."""
    harness.run(**{**ARM, "task": "fd100-reach:horizon=20"}, seeds=1, measure=[file], out=tmp_path / "R", jobs=1)  # type: ignore[arg-type]
    (comparison,) = load_results(tmp_path / "R", measures=[file]).combinations
    assert comparison.measured.deciding == ("success_rate", "time_to_target")


def test_without_its_file_what_decides_is_not_known(folder):
    """And nothing else decides in its place."""
    results = load_results(folder)
    assert results.not_measured == {
        "near": "the experiment names it, and nobody registered it: give its file, --measure FILE"
    }
    assert results.combinations[0].headline.answer == "cannot tell"
    assert results.combinations[0].decisive_changes == ()


def test_chosen_metrics_stand_beside_what_decides(folder, file):
    """``--metric work`` shows it and the one that decides."""
    assert list(load_results(folder, metrics="work", measures=[file]).metrics) == ["near", "work"]


def test_table_has_a_column_of_each(folder):
    """Written by the run."""
    rows = pq.read_table(folder / "results.parquet").to_pylist()
    assert all(row["calm"] > 0.0 and 0.0 <= row["near"] <= 1.0 for row in rows)


def test_trackers_are_told_them(folder, file):
    """Live, under their names."""
    registry = load_registry(given=read_given((), [file]))
    trace = read_trace(next(folder.glob("cells/*/evaluation.parquet")))
    assert {"Evaluation/Calm", "Evaluation/Near"} <= evaluation_scalars(trace, registry).keys()


def test_experiment_file_names_their_file(results, file):
    """And commands that read it are told to give it."""
    (need,) = results.plan.experiment["plugins"]
    assert (need["path"], need["measures"]) == (str(file), True)
    assert results.report_flags == results.plugin_flags == f" --measure {file}"
