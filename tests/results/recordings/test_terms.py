"""Terms of rewards in environments, read from recordings; and one reward alone."""

from dataclasses import replace

import numpy as np
import pytest

from harness import load_results
from harness.record import read_recording
from harness.record.recording.facts import Failure
from harness.record.recording.recording_writer import write_recording
from harness.score.weighted_recordings import weighed
from tests.results.recordings.conftest import PULLS, record

CALM = {"near": lambda arm: arm, "calm": lambda arm: -0.5 * arm, "dock": lambda arm: 0.0 * arm}
BOLD = {"near": lambda arm: 2.0 * arm}
PAYS = {
    "bold": lambda arm: 2.0 * arm,
    "calm": lambda arm: arm - 0.5 * arm + 0.0 * arm,
}


def _rewritten(folder, recording):
    """The folder with this recording in place of its own."""
    for path in [it for it in folder.iterdir() if it.is_file()]:
        path.unlink()
    write_recording(folder, recording)
    return folder


def _record(folder, trained_with, seed, arms, **facts):
    """A recording whose rewards have terms."""
    record(folder, trained_with, seed, arms, pays=PAYS, **facts)
    recording = read_recording(folder).load()
    pulled = np.repeat(arms, PULLS)
    of = {"bold": BOLD, "calm": CALM}
    terms = {f"reward/{reward}/{it}": pay(pulled) for reward, some in of.items() for it, pay in some.items()}
    names = {reward: tuple(some) for reward, some in of.items()}
    return _rewritten(folder, replace(recording, facts=replace(recording.facts, terms=names)).add(terms))


@pytest.fixture(name="folder")
def _folder(tmp_path):
    for seed in range(3):
        for reward, end in (("bold", 0.4), ("calm", 0.8)):
            place = _record(tmp_path / f"{reward}-{seed}", reward, seed, np.linspace(0.0, end + 0.01 * seed, 20))
            arms = np.full(4, end + 0.01 * seed)
            _record(place / "evaluation", reward, seed, arms, evaluation=True, acted="deterministic")
    return tmp_path


@pytest.fixture(name="results")
def _results(folder):
    return load_results(folder)


def test_each_reward_that_taught_is_told_by_term(results):
    """The baseline alone, the other one beside it."""
    told = {it.reward: (it.baseline, [term.name for term in it.terms]) for it in results.terms}
    assert told == {"bold": ("", ["near"]), "calm": ("bold", ["near", "calm", "dock"])}


def test_stages_are_those_of_the_columns(results):
    """Worked out from the arms: an episode pulls one arm five times; the first two of 20 episodes are the start."""
    near = results.terms[1].terms[0]
    ends = np.array([0.8, 0.81, 0.82])
    arms = np.linspace(np.zeros(3), ends, 20)
    assert near.start.value == pytest.approx(PULLS * arms[:2].mean())
    assert near.end.value == pytest.approx(PULLS * arms[-2:].mean())
    assert near.evaluation.value == pytest.approx(PULLS * ends.mean())


def test_a_reward_with_weights_is_compared_by_term(folder):
    """The baseline's recordings have the terms, but no column of the reward with these weights."""
    for path in [*folder.glob("calm-*/evaluation"), *folder.glob("calm-?")]:
        label = "calm:calm=3"
        found = weighed(read_recording(path), [label]).load()
        found = replace(found, facts=replace(found.facts, trained_with=label))
        _rewritten(path, found)
    (_, heavy) = load_results(folder).terms
    own, others = PULLS * 0.81, PULLS * 0.41
    assert heavy.reward == "calm:calm=3"
    assert [it.others.value for it in heavy.terms] == pytest.approx([others, -1.5 * others, 0.0])
    assert [it.behaviour.value for it in heavy.terms] == pytest.approx([own - others, -1.5 * (own - others), 0.0])


def test_behaviour_and_ruler_by_term_add_up(results):
    """To what the evaluations of both rewards are paid."""
    calm = results.terms[1]
    own, others = PULLS * 0.81, PULLS * 0.41
    assert [it.behaviour.value for it in calm.terms] == pytest.approx([own - others, -0.5 * (own - others), 0.0])
    assert calm.terms[0].ruler.value == pytest.approx(others - 2.0 * others)
    (split,) = (it for manner, it in results.combinations[0].number.returns.items() if manner == "in evaluations")
    returns = {pair: mean.value or 0.0 for pair, mean in split.returns.items()}
    total = returns["proposed", "proposed"] - returns["proposed", "baseline"]
    assert sum(it.behaviour.value or 0.0 for it in calm.terms) == pytest.approx(total, rel=1e-12)


def test_a_term_that_never_pays_is_named(results):
    """In all steps of all trainings of the reward."""
    assert [(it.never, it.steps) for it in results.terms] == [((), 300), (("dock",), 300)]


def test_a_reward_that_was_given_up_tells_no_terms_of_that_training(folder):
    """The others are told."""
    broken = folder / "calm-2"
    recording = read_recording(broken).load()
    columns = [name for name in recording.names if name.startswith("reward/calm")]
    gone = {name: np.where(np.arange(len(recording)) > 50, np.nan, recording[name]) for name in columns}
    failure = Failure("reward/calm", "ZeroDivisionError: by nothing", env=0, episode=10, step=1)
    _rewritten(broken, replace(recording, facts=replace(recording.facts, failed=(failure,))).add(gone))
    (calm,) = (it for it in load_results(folder).terms if it.reward == "calm")
    assert (calm.terms[0].start.seeds, calm.terms[0].start.note) == (
        2,
        "2 seeds: no interval below 3 seeds; 1 of 3 have none",
    )


def test_one_reward_alone_is_told(tmp_path):
    """What it paid and what the agent did, at the start, at the end and in the evaluations."""
    for seed in range(3):
        _record(tmp_path / str(seed), "calm", seed, np.linspace(0.0, 1.0, 20))
    results = load_results(tmp_path)
    (alone,) = results.alone
    success = next(it for it in alone.behaviour if it.measure.name == "success")
    assert results.combinations == ()
    assert (alone.reward, alone.seeds, alone.shown) == ("calm", (0, 1, 2), ("success", "return paid by calm"))
    assert (success.start.value, success.end.value, success.evaluation.value) == (0.0, 1.0, None)
    assert alone.paid.end.value == pytest.approx(PULLS * 0.5 * np.linspace(0.0, 1.0, 20)[-2:].mean())


def test_two_rewards_are_not_alone(results):
    """They are compared."""
    assert (results.alone, len(results.combinations)) == ((), 1)
