"""Plain functions of a step or of an episode as measures of an arm."""

import math

import numpy as np
import pytest

from harness import load_registry
from harness.errors import Unmeasured, UsageError
from harness.log import episode_facts, trace_of
from harness.log.measure import bounds_of, is_share, needs_of
from harness.registry import build_defaults, fingerprint, read_given
from harness_plugins.kit import check_contract
from harness_plugins.kit.metrics import recorded_trace

ENDS = ("reached", "ground", "truncated", "truncated", "")
HEAD = "import numpy as np\n"
LENGTH = HEAD + (
    "def path_length(episode):\n"
    '    """Way of the end effector."""\n'
    "    return np.linalg.norm(episode.end_effector - episode.before.end_effector, axis=-1).sum()\n"
)


def _registry(folder, source, name="behaviour.py"):
    (folder / name).write_text(source, encoding="utf-8")
    return load_registry([], read_given((), [folder / name]))


@pytest.fixture(name="made")
def _made(tmp_path):
    """The measure of a name in a source."""

    def make(source, name="calm"):
        measure = build_defaults(_registry(tmp_path, source), "metrics", [name])[name]
        return measure

    return make


@pytest.fixture(name="trace")
def _trace():
    return recorded_trace(0, ENDS)


def test_function_of_a_step_says_what_its_last_step_says(made, trace):
    """As in environments; the mean over finished episodes."""
    value = made("def calm(step):\n    return step.distance")(trace)
    assert value == pytest.approx(trace["distance"][trace.last_rows].mean())


def test_function_of_an_episode_is_given_its_steps_without_the_start(made, trace):
    """The mean over finished episodes of their lengths."""
    lengths = [len(rows) - 1 for rows in trace.episodes]
    assert made("def calm(episode):\n    return len(episode.step)")(trace) == np.mean(lengths)


def test_before_of_the_first_step_is_the_start_row(made, trace):
    """So differences add up to the whole way."""
    places = np.stack([trace[f"end_effector_{axis}"] for axis in "xyz"], axis=1)
    ways = [np.linalg.norm(np.diff(places[rows], axis=0), axis=1).sum() for rows in trace.episodes]
    assert made(LENGTH, "path_length")(trace) == pytest.approx(np.mean(ways))


def test_envs_side_by_side_are_measured_each_for_itself(made, trace):
    """Rows of two envs that alternate say what they say one after the other."""
    other = recorded_trace(1, ENDS)
    columns = {name: np.concatenate([trace[name], other[name]]) for name in trace.columns}
    columns["env"] = np.repeat([0, 1], [len(trace), len(other)]).astype(np.int32)
    mixed = np.argsort(np.concatenate([np.arange(len(trace)) * 2, np.arange(len(other)) * 2 + 1]), kind="stable")
    both = trace_of({name: values[mixed] for name, values in columns.items()}, episode_facts(trace))
    measure = made(LENGTH, "path_length")
    assert measure(both) == pytest.approx((measure(trace) + measure(other)) / 2)


def test_what_is_true_or_false_is_a_share(made):
    """Its bounds are those of a share."""
    measure = made("def calm(step):\n    return step.distance < 0.5")
    assert (is_share(measure), bounds_of(measure)) == (True, (0.0, 1.0))


def test_success_is_a_share_whatever_it_returns(made):
    """As the measure of this name in environments."""
    assert is_share(made("def success(step):\n    return 1.0 * (step.distance < 0.5)", "success"))


def test_other_numbers_are_no_share(made):
    """The mutant of the two before."""
    measure = made("def calm(step):\n    return step.distance")
    assert (is_share(measure), bounds_of(measure)) == (False, (-math.inf, math.inf))


def test_file_says_unit_direction_and_bounds(made):
    """Under the names that environments have."""
    source = "lower_is_better = ['calm']\nunits = {'calm': 'm'}\nbounds = {'calm': (0, 9.0)}\n"
    measure = made(source + "def calm(step):\n    return step.distance")
    assert (measure.unit, measure.better, bounds_of(measure)) == ("m", "lower", (0, 9.0))


@pytest.mark.parametrize(
    ("source", "better"),
    [
        ("def calm(step):\n    return step.distance", ""),
        ("higher_is_better = ['calm']\ndef calm(step):\n    return step.distance", "higher"),
        ("def calm(step):\n    return step.distance < 1.0", "higher"),
        ("lower_is_better = ['calm']\ndef calm(step):\n    return step.distance < 1.0", "lower"),
    ],
)
def test_without_a_word_only_what_is_true_or_false_has_a_direction(made, source, better):
    """And there is no unit."""
    measure = made(source)
    assert (measure.unit, measure.better) == ("", better)


@pytest.mark.parametrize(
    ("read", "needs"),
    [("step.qvel.max(-1)", {"qvel"}), ("step.before.action.max(-1) - step.distance", {"before.action", "distance"})],
)
def test_one_call_tells_what_it_reads(made, read, needs):
    """By names of the fields of a step."""
    assert needs_of(made(f"def calm(step):\n    return {read}")) == needs


def test_field_that_was_not_recorded_is_named(made, trace):
    """A trace of before has no joint speeds: there is no value, and a reason."""
    old = trace_of(trace.rows(name for name in trace.names if name != "qvel").columns)
    measure = made("def calm(step):\n    return abs(step.qvel).max(-1)")
    assert measure(trace) is not None
    with pytest.raises(Unmeasured, match="it reads qvel, which was not recorded"):
        measure(old)


def test_field_that_made_up_steps_do_not_show_is_there(made, trace):
    """One that it reads of long episodes alone."""
    source = "def calm(episode):\n    return 1.0 if len(episode.step) == 16 else episode.qpos[-1].sum()"
    assert made(source)(trace) == pytest.approx(np.mean([trace["qpos"][rows[-1]].sum() for rows in trace.episodes]))


def test_episode_may_have_no_value(made, trace):
    """It is left out of the mean; if none has one, there is none."""
    some = made("def calm(episode):\n    return None if episode.ground[-1] else 2.0")
    assert some(trace) == 2.0
    assert made("def calm(episode):\n    return None")(trace) is None


BAD = {
    "one number": (
        "def calm(step):\n    return step.distance.max()",
        "it returned one number for 2 steps: return one ",
    ),
    "too many": ("def calm(step):\n    return step.action", r"an array of shape \(2, 6\) for 2 steps"),
    "many of an episode": (
        "def calm(episode):\n    return episode.distance",
        r"shape \(16,\) for an episode: ",
    ),
    "text": ("def calm(step):\n    return 'much'", "it returned 'much' for 2 steps, which is no number"),
    "nan": ("def calm(episode):\n    return float('nan')", "it returned nan for an episode"),
    "unknown": ("def calm(step):\n    return step.joint_speed", "has no 'joint_speed'.*Did you mean 'qvel'"),
    "length": ("def calm(episode):\n    return len(episode)", r"len\(episode.step\) is that of an episode's steps"),
    "list": ("def calm(episode):\n    return sum(it for it in episode)", "and not a list"),
    "row": ("def calm(episode):\n    return episode[-1]", r"read a row of a field, episode.distance\[-1\]"),
    "raises": ("def calm(step):\n    return {}['no']", "It fails on made-up steps of 2 arms: KeyError"),
}


@pytest.mark.parametrize(("source", "told"), BAD.values(), ids=BAD)
def test_what_fails_is_told_with_its_name(made, source, told):
    """Before a run, by the call on made-up steps."""
    with pytest.raises(UsageError, match=f"Measure 'calm': .*{told}"):
        made(source)


def test_value_outside_of_its_bounds_is_none(made, trace):
    """Intervals would be wrong."""
    with pytest.raises(Unmeasured, match=r"it is 2 in an episode.* 0 and 1"):
        made("def success(step):\n    return 2.0 + 0.0 * step.distance", "success")(trace)


@pytest.mark.parametrize(
    ("said", "told"),
    [
        ("units = {'clam': 'm'}", "units names 'clam', which is none of calm"),
        ("bounds = {'clam': (0, 1)}", "bounds names 'clam', which is none of calm"),
        ("bounds = {'calm': (1, 0)}", r"bounds\['calm'\] is \(1, 0\): write two numbers, the lower one first"),
        ("units = 'm'", "units is 'm': write a dict by name of a measure"),
    ],
)
def test_file_that_says_what_cannot_be_is_refused(tmp_path, said, told):
    """With its name."""
    with pytest.raises(UsageError, match=rf"behaviour\.py': {told}"):
        _registry(tmp_path, f"{said}\ndef calm(step):\n    return step.distance")


def test_file_for_environments_alone_may_call_anything_bounds(tmp_path):
    """As it could before arms had measures of files."""
    source = "bounds = [1, 2]\ndef calm(observation, action, next_observation, info):\n    return 1.0"
    assert [it.name for it in _registry(tmp_path, source).functions] == ["calm"]


@pytest.mark.parametrize(
    "source", ["def calm(step):\n    return step.qvel.max(-1)", LENGTH.replace("path_length", "calm")]
)
def test_it_keeps_the_contract_of_metrics(made, source):
    """Every check, on traces of all kinds."""
    check_contract("metric", made(source))


def test_its_fingerprint_follows_an_edit(tmp_path):
    """Of the file, and of one beside it: kept numbers are computed anew."""
    sources = [LENGTH, LENGTH + "# edited\n", "from parts import half\n" + LENGTH]
    seen = []
    for parts in ("half = 0.5\n", "half = 0.25\n"):
        (tmp_path / "parts.py").write_text(parts)
        for source in sources:
            built = build_defaults(_registry(tmp_path, source), "metrics", ["path_length"])["path_length"]
            seen.append(fingerprint(built))
    assert len(set(seen)) == 4
    assert seen[:2] == seen[3:5]


def test_name_of_a_built_in_metric_is_refused(tmp_path):
    """A table would show two things under one name."""
    (tmp_path / "behaviour.py").write_text("def work(step):\n    return step.distance")
    with pytest.raises(UsageError, match=r"the name of metric 'work' is taken by .*Rename the function"):
        load_registry(given=read_given((), [tmp_path / "behaviour.py"]))


def test_episode_is_no_argument_of_rewards(tmp_path):
    """A reward pays steps."""
    (tmp_path / "mine.py").write_text("def mine(episode):\n    return 1.0")
    with pytest.raises(UsageError, match=r"it has mine\(episode\), and a reward or a measure takes \(step\)"):
        load_registry([], read_given([tmp_path / "mine.py"]))
