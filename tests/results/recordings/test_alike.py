"""What is the same in recorded trainings."""

from dataclasses import replace

import numpy as np
import pytest

from harness.eta import Answer, rescaling_of
from harness.record import read_recording
from harness.report import beside_answer
from harness.report.page.answer import card_of
from harness.report.rows.comparison import UNLIKE_STARTS, scale_text
from harness.results.recordings.recording_results import Likeness, likeness_of
from tests.results.recordings.conftest import load_study, record

ARMS = np.linspace(0.0, 1.0, 20)


@pytest.fixture
def training(tmp_path):
    """A training that was recorded."""
    return read_recording(record(tmp_path / "a", "plain", 0, ARMS))


def test_the_reward_that_taught_is_no_difference(training):
    """Nor is anything else that is no step."""
    other = replace(training, facts=replace(training.facts, trained_with="thrice", seed=5, versions={"numpy": "9"}))
    assert likeness_of(other).digest == likeness_of(training).digest != ""


CHANGES = {
    "a payment": lambda it: {"reward/plain": np.nextafter(it["reward/plain"], 9.0)},
    "a measure": lambda it: {"behaviour/arm": it["behaviour/arm"] + 1e-15},
    "an end": lambda it: {"truncated": np.roll(it["truncated"], 1)},
    "an episode": lambda it: {"episode": it["episode"] + np.int32(1)},
}


@pytest.mark.parametrize("change", CHANGES)
def test_any_step_is_a_difference(training, change):
    """In its last bit."""
    other = training.add(CHANGES[change](training))
    assert likeness_of(other).digest != likeness_of(training).digest


def test_a_name_is_a_difference(training):
    """The numbers are the same."""
    other = training.renamed({"behaviour/arm": "behaviour/other"})
    other = replace(other, facts=replace(training.facts, behaviour=("other", "success")))
    assert likeness_of(other).digest != likeness_of(training).digest


def test_numbers_that_never_change_tell_nothing(training):
    """A training in which nothing was ever paid is like any other such, whatever the learner did."""
    zeros = {name: np.zeros(len(training)) for name in training.names if name.startswith(("reward/", "behaviour/"))}
    assert likeness_of(training.add(zeros)).digest == ""


def test_each_reward_is_told_once(tmp_path):
    """By the first one that it is but for its scale."""
    pays = {"plain": lambda a: a, "twice": lambda a: 2.0 * a, "square": lambda a: a**2, "less": lambda a: 1.0 - a}
    for reward, shift in (("plain", 0.0), ("square", 0.1)):
        record(tmp_path / reward, reward, 0, ARMS + shift, pays=pays)
    twice, less = load_study(tmp_path).notes
    assert (twice.split(",")[0], less.split(",")[0]) == ("twice is 2 x plain", "less is -1 x plain + 1")


def test_a_reward_that_is_not_known_everywhere_is_compared_where_it_is(tmp_path):
    """In the recordings that know both."""
    record(tmp_path / "plain", "plain", 0, ARMS)
    record(tmp_path / "thrice", "thrice", 0, ARMS + 0.1)
    record(tmp_path / "more", "plain", 1, ARMS, pays={"plain": lambda arms: arms + 1.0})
    record(tmp_path / "odd", "thrice", 1, ARMS, failures={"reward/plain": 12})
    (told,) = load_study(tmp_path).notes
    assert told.startswith(f"thrice is 3 x plain + 3, in all {2 * 5 * len(ARMS)} steps")


@pytest.mark.parametrize("ends", [False, True])
def test_an_offset_is_no_ruler_where_an_episode_terminated(training, ends):
    """In one that was cut only, it pays every episode the same."""
    likeness = likeness_of(training.add({"terminated": training["truncated"] & ends}))
    rescaling = rescaling_of([likeness.line("plain", "thrice")])
    assert rescaling is not None
    assert (rescaling.is_ruler, rescaling.can_end) == (not ends, ends)


def test_likeness_comes_back_from_json(training):
    """As it was kept."""
    likeness = likeness_of(training.add({"terminated": training["truncated"]}))
    assert Likeness.from_json(likeness.to_json()) == likeness


@pytest.mark.parametrize(
    ("pays", "is_told"),
    [
        (lambda arms: 3.0 * (arms + 1.0), True),
        (lambda arms: 3.0 * (arms + 1.0) + 1.0, True),
        (lambda arms: -1.0 * (arms + 1.0), False),
        (lambda arms: arms**2, False),
    ],
)
def test_where_only_the_scale_differs_the_answer_says_so(tmp_path, pays, is_told):
    """Beside the answer of a comparison whose behaviour differs: on the card, and in the terminal."""
    rewards = {"plain": lambda arms: arms + 1.0, "other": pays}
    for seed in range(6):
        record(tmp_path / f"plain-{seed}", "plain", seed, 0.3 * ARMS + 0.01 * seed, pays=rewards)
        record(tmp_path / f"other-{seed}", "other", seed, ARMS + 0.01 * seed, pays=rewards)
    (comparison,) = load_study(tmp_path).combinations
    assert comparison.headline.answer is Answer.HELPS
    told = scale_text(comparison)
    assert ("so its scale decides here" in told) is is_told
    assert card_of(comparison, "other").beside == ((told,) if told else ())
    assert scale_text(replace(comparison, answer=replace(comparison.answer, ruling=None))) == ""


def test_other_starts_are_told_beside_the_answer(tmp_path):
    """Those of an evaluation on the way too."""
    for reward, starts in (("plain", 7), ("thrice", 8)):
        record(tmp_path / reward, reward, 0, ARMS)
        record(tmp_path / reward / "half", reward, 0, ARMS, evaluation=True, after=50, starts=starts)
    (comparison,) = load_study(tmp_path).combinations
    assert not comparison.measured.same_starts
    assert beside_answer(comparison) == [UNLIKE_STARTS]
    assert card_of(comparison, "thrice").beside == (UNLIKE_STARTS,)
    assert beside_answer(replace(comparison, measured=replace(comparison.measured, same_starts=True))) == []
