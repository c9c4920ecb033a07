import math
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from harness.errors import UsageError
from harness.eta.scored_sums import BB, KK
from harness.eta.verdict.ruling import Ruling
from harness.log import in_memory
from harness.record.recording.facts import OWN_SOURCE, Source, TrainingFacts
from harness.report.rows.comparison import basis_text
from harness.results.learning import STRETCHES
from harness.results.recordings.episodes import episodes_of
from harness.results.recordings.read_runs import read_runs
from harness.results.recordings.run_trainings import return_name
from harness.results.recordings.runs import EVALUATION, LAST, TRAINING
from harness.results.recordings.study import PlaceStudy, studies_of_runs
from tests.results.recordings.conftest import PAYS, PULLS, load_study, record

RISING = np.linspace(0.0, 1.0, 20)


def two(folder: Path, seeds: int = 2, **facts) -> Path:
    """Trainings with two rewards."""
    for seed in range(seeds):
        for reward in ("plain", "thrice"):
            record(folder / f"{reward}-{seed}", reward, seed, RISING + 0.01 * seed, **facts)
    return folder


ALIKE = ("The trainings by plain ", "thrice is 3 x plain + 3, in all")
"""What is told of most studies here: trainings are equal bit for bit, and rewards differ in scale and offset alone."""


def notes_of(folder: Path) -> list[str]:
    """All other notes."""
    return [note for note in load_study(folder).runs.notes if not note.startswith(ALIKE)]


def test_a_reward_helps_by_a_corrected_test(study_folder):
    """All six seeds end with success under one reward and with none under the other."""
    (comparison,) = load_study(study_folder).comparisons
    assert comparison.headline.answer.value == "helps"
    assert comparison.headline.decided_by == "success"
    assert comparison.decisive.corrected == pytest.approx(2 / math.comb(12, 6))


def test_without_evaluations_the_verdict_says_that_it_rests_on_training(study_folder):
    """On its last part, and how to do better."""
    (comparison,) = load_study(study_folder).comparisons
    assert comparison.manner == LAST
    assert "rests on the training itself" in basis_text(comparison)
    assert "harness.evaluate_policy" in basis_text(comparison)


def test_evaluations_that_are_not_there_for_all_do_not_decide(study_folder):
    """One of twelve is told, and the training decides."""
    record(study_folder / "plain-0" / "evaluation", "plain", 0, [0.2, 0.3], evaluation=True)
    study = load_study(study_folder)
    assert study.comparisons[0].manner == LAST
    assert "11 of 12 trainings have no evaluation beside them" in study.runs.notes
    assert study.tables[EVALUATION]["plain", "plain"].mean == pytest.approx(PULLS * 1.25)


def test_an_evaluation_without_its_training_is_left_out(tmp_path):
    """It is told, and nothing else changes."""
    record(two(tmp_path) / "lost", "plain", 7, [0.1], evaluation=True)
    (note,) = notes_of(tmp_path)
    assert "it evaluates plain of seed 7, whose training is not in" in note


def test_chosen_measures_are_compared_alone(study_folder):
    """Beside the one that decides."""
    assert load_study(study_folder, metrics="success").runs.measures == ("success",)
    assert load_study(study_folder, metrics=["arm"]).runs.measures == ("success", "arm")


def test_measure_that_is_not_recorded_is_refused(study_folder):
    """With those that are."""
    with pytest.raises(UsageError, match=r"No measure 'leg'\. There is: arm, success"):
        load_study(study_folder, metrics="leg")


def test_returns_are_means_over_episodes_then_over_seeds(study_folder):
    """Of the last fifth: those of its episodes alone."""
    split = load_study(study_folder).comparisons[0].number.returns[LAST]
    arms = [np.linspace(0.0, 0.4 + 0.01 * seed, 40)[-8:].mean() for seed in range(6)]
    assert split.returns[BB].mean == pytest.approx(np.mean([PULLS * (arm + 1.0) for arm in arms]))
    assert split.returns[KK].low < split.returns[KK].mean < split.returns[KK].high


def test_an_unfinished_episode_does_not_count(tmp_path):
    """A training that is cut in the middle of an episode has the mean of those before."""
    study = load_study(two(tmp_path))
    assert study.runs.members["plain", 0].parts(PULLS * 2 + 3)[TRAINING].episodes == 2


@pytest.mark.parametrize("shift", [-3.0, 0.0])
def test_a_ratio_takes_positive_returns(tmp_path, shift):
    """Otherwise the reason stands in its place, the difference is split all the same, and words tell that."""
    pays = {"plain": lambda arm: arm + shift, "thrice": lambda arm: 3.0 * arm + shift}
    (comparison,) = load_study(two(tmp_path, pays=pays)).comparisons
    split = comparison.number.returns[TRAINING]
    assert (split.ratio.eta.value is None) == (shift < 0.0)
    assert split.total.change.mean == pytest.approx(split.total.ruler.mean + split.total.behaviour.mean)
    if shift:
        assert "is not above 0" in split.ratio.eta.note
        assert "Rescaling alone (the ruler)" in comparison.number.sentence(comparison.names)


def test_signs_of_the_summed_curve_decide_which_indices_there_are(tmp_path):
    """A sum that is always negative has I_N alone."""
    pays = {"plain": lambda arm: arm - 2.0, "thrice": lambda arm: arm - 4.0}
    (comparison,) = load_study(two(tmp_path, pays=pays)).comparisons
    assert list(comparison.number.index_splits) == ["eta_N"]


def test_more_rewards_are_compared_with_the_first_one(tmp_path):
    """Each against it, and all hints are corrected together."""
    pays = {**PAYS, "half": lambda arm: arm / 2.0}
    for reward in pays:
        for seed in range(2):
            record(tmp_path / f"{reward}-{seed}", reward, seed, RISING, pays=pays)
    study = load_study(tmp_path)
    assert [it.names for it in study.comparisons] == [("plain", "thrice"), ("plain", "half")]
    assert len(study.tables[TRAINING]) == 9
    assert len({it.answer.claims for it in study.comparisons}) == 1


def test_studies_of_one_experiment_are_one_family(tmp_path):
    """The claims of all groups of trainings are corrected together: none is more significant than alone."""
    for group in ("first", "second"):
        for reward, arms in (("plain", RISING), ("thrice", [1.0 - arm for arm in RISING])):
            for seed in range(5):
                record(tmp_path / group / f"{reward}-{seed}", reward, seed, [arm + 0.01 * seed for arm in arms])
    alone = load_study(tmp_path / "first")
    together = studies_of_runs(tmp_path, [read_runs(tmp_path / group) for group in ("first", "second")], "accumulated")
    count = alone.comparisons[0].answer.claims
    assert count > 1
    assert [it.comparisons[0].answer.claims for it in together] == [2 * count, 2 * count]
    pairs = zip(alone.comparisons[0].measured.changes, together[0].comparisons[0].measured.changes, strict=True)
    assert all(of_all.corrected >= of_one.corrected for of_one, of_all in pairs if of_one.corrected is not None)


def test_a_reward_that_taught_nobody_pays_all_the_same(tmp_path):
    """It is a row of the full table, and no comparison."""
    study = load_study(two(tmp_path, pays={**PAYS, "other": lambda arm: arm}))
    assert len(study.comparisons) == 1
    assert ("other", "plain") in study.tables[TRAINING]


def test_a_measure_of_which_less_is_better(tmp_path):
    """As it was recorded."""
    (comparison,) = load_study(two(tmp_path, lower_is_better=("arm",))).comparisons
    assert {it.name: it.measure.better for it in comparison.measured.changes} == {"success": "higher", "arm": "lower"}


def test_a_measure_of_zeros_and_ones_is_a_share(tmp_path):
    """Its interval knows of the episodes, any other's does not."""
    (comparison,) = load_study(two(tmp_path)).comparisons
    assert {it.name: it.measure.episodes for it in comparison.measured.changes_of(LAST)} == {"success": 4, "arm": None}


def test_without_behaviour_rewards_alone_decide_nothing(tmp_path):
    """The number is told, the agent is not judged."""
    headline = load_study(two(tmp_path, behaviour={})).comparisons[0].headline
    assert headline.answer.value == "cannot tell"
    assert headline.robot.startswith("How the robot behaves was not measured")
    assert "times as much" in headline.number


def test_one_seed_has_values_and_no_interval(tmp_path):
    """And nothing can be told from it."""
    (comparison,) = load_study(two(tmp_path, seeds=1)).comparisons
    ratio = comparison.number.returns[TRAINING].ratio
    assert (ratio.eta.low, ratio.p) == (None, None)
    assert ratio.eta.value is not None
    assert "one seed: no interval below 3 seeds" in ratio.eta.notes
    assert comparison.headline.answer.value == "cannot tell"


def test_longer_trainings_are_cut_to_the_shortest(tmp_path):
    """It is told which that is."""
    record(two(tmp_path) / "short-plain", "plain", 9, RISING[:10])
    record(tmp_path / "long-thrice", "thrice", 9, RISING)
    study = load_study(tmp_path)
    assert study.runs.steps == 10 * PULLS
    assert study.runs.members["thrice", 9].parts(study.runs.steps)[TRAINING].episodes == 10
    assert any("cut to the 50 steps of the shortest" in note and "short-plain" in note for note in study.runs.notes)


def test_a_reward_that_was_given_up_is_not_known_in_that_training(tmp_path):
    """No split, with the reason; each training's own return is there."""
    record(two(tmp_path) / "odd", "plain", 2, RISING, failures={"reward/thrice": 12})
    record(tmp_path / "even", "thrice", 2, RISING)
    study = load_study(tmp_path)
    split = study.comparisons[0].number.returns[TRAINING]
    assert not split.is_split
    assert "given up in step 2 of episode 2: ZeroDivisionError" in split.ratio.ruler.note
    assert split.ratio.eta.value is not None
    assert "1 of 3 seeds have none" in study.tables[TRAINING]["thrice", "plain"].note


def test_an_own_reward_that_was_given_up_leaves_no_return(tmp_path):
    """The reason stands in place of the number; the behaviour is judged all the same."""
    record(two(tmp_path) / "odd", "thrice", 2, RISING, failures={"reward/thrice": 12})
    record(tmp_path / "even", "plain", 2, RISING)
    (comparison,) = load_study(tmp_path).comparisons
    assert (comparison.number.returns, comparison.number.decomposition) == ({}, None)
    assert "given up" in comparison.number.sentence(comparison.names)
    assert comparison.decisive.seeds == 3


def test_a_share_that_was_given_up_in_one_training_stays_a_share(tmp_path):
    """Of the trainings that have it."""
    record(two(tmp_path) / "odd", "thrice", 2, RISING, failures={"behaviour/success": 12})
    record(tmp_path / "even", "plain", 2, RISING)
    decisive = load_study(tmp_path).comparisons[0].decisive
    assert (decisive.counts, decisive.without, decisive.measure.episodes) == ((3, 2), (0, 1), 4)
    assert "given up in step 2 of episode 2" in decisive.reason


def test_a_reward_that_one_training_did_not_record(tmp_path):
    """It cannot pay that one."""
    record(two(tmp_path) / "odd", "plain", 2, RISING, pays={"plain": PAYS["plain"]})
    record(tmp_path / "even", "thrice", 2, RISING)
    assert "odd': not recorded" in load_study(tmp_path).comparisons[0].number.returns[TRAINING].ratio.ruler.note


def test_what_the_env_pays_is_another_reward_in_another_training(tmp_path):
    """Recorded as ``own`` where the env paid another one, it is not taken for the reward of that name."""
    pays = {"plain": PAYS["thrice"], "thrice": PAYS["thrice"]}
    sources = {"reward_plain": Source("", OWN_SOURCE)}
    for seed in range(2):
        record(tmp_path / f"plain-{seed}", "plain", seed, RISING, sources=sources)
        record(tmp_path / f"thrice-{seed}", "thrice", seed, RISING, pays=pays, sources=sources)
    (comparison,) = load_study(tmp_path).comparisons
    assert not comparison.number.returns[TRAINING].is_split
    assert "that was thrice here" in comparison.number.returns[TRAINING].ratio.ruler.note


def test_code_that_changed_between_trainings_is_told(tmp_path):
    """A reward of one name has to be one reward."""
    for seed, text in enumerate(("return 1", "return 2")):
        sources = {"reward_plain": Source("", text), "reward_thrice": Source("", "the same")}
        for reward in PAYS:
            record(tmp_path / f"{reward}-{seed}", reward, seed, RISING, sources=sources)
    (note,) = notes_of(tmp_path)
    assert "The code of reward plain is not the same in" in note


def test_an_evaluation_may_lack_a_measure(tmp_path):
    """It is n/a there, with the reason."""
    two(tmp_path)
    for seed in range(2):
        for reward in PAYS:
            record(tmp_path / f"{reward}-{seed}" / "e", reward, seed, [0.1], evaluation=True, behaviour={})
    comparison = load_study(tmp_path).comparisons[0]
    assert comparison.manner == EVALUATION
    assert "success is not known: success in " in comparison.headline.robot
    assert "not recorded" in comparison.headline.robot


def test_of_seeds_that_only_one_reward_has_behaviour_is_compared(tmp_path):
    """What is paid is compared on the seeds of both."""
    record(two(tmp_path) / "more", "plain", 8, RISING)
    study = load_study(tmp_path)
    found = study.comparisons[0]
    assert (found.seeds, found.trained) == ((0, 1), ((0, 1, 8), (0, 1)))
    assert found.decisive.counts == (3, 2)
    assert study.tables[TRAINING]["plain", "plain"].seeds == 3


def test_no_seed_in_common(tmp_path):
    """Behaviour is compared; that nothing else is, is said."""
    record(tmp_path / "one", "plain", 0, RISING)
    record(tmp_path / "other", "thrice", 1, RISING)
    (comparison,) = load_study(tmp_path).comparisons
    assert comparison.decisive.counts == (1, 1)
    assert "no seed is done under both plain and thrice" in comparison.number.sentence(comparison.names)


def test_trainings_without_a_seed_are_numbered(tmp_path):
    """In the order of their folders."""
    for name, reward in zip("abcd", ("plain", "thrice") * 2, strict=True):
        record(tmp_path / name, reward, None, RISING)
    study = load_study(tmp_path)
    assert sorted(study.runs.members) == [("plain", 0), ("plain", 1), ("thrice", 0), ("thrice", 1)]
    assert "4 trainings recorded without a seed" in study.runs.notes[0]


def test_two_trainings_of_one_seed_are_refused(tmp_path):
    """Both folders are named."""
    record(two(tmp_path) / "again", "plain", 1, RISING)
    with pytest.raises(UsageError, match=r"again' and '.*plain-1' were both trained with plain and seed 1"):
        load_study(tmp_path)


def test_several_envs_are_refused(tmp_path):
    """Each is named, with a folder of it."""
    record(two(tmp_path) / "other", "plain", 5, RISING, spec={"id": "Other-v1"})
    with pytest.raises(UsageError, match=r"mixes trainings in several envs: Other-v1 .*Bandit-v0"):
        load_study(tmp_path)


def test_an_env_made_with_other_arguments_is_told(tmp_path):
    """It may be how rewards are chosen, so nothing is refused."""
    record(two(tmp_path) / "other", "plain", 5, RISING, spec={"id": "Bandit-v0", "kwargs": {"reward": "plain"}})
    assert "different arguments: {'reward': 'plain'} and {}" in load_study(tmp_path).runs.notes[0]


def test_one_reward_alone_is_compared_with_nothing(tmp_path):
    """What it paid for is told elsewhere."""
    record(tmp_path / "one", "plain", 0, RISING)
    assert load_study(tmp_path).comparisons == ()


def test_a_folder_without_recordings_is_refused(tmp_path):
    """What makes one is said."""
    with pytest.raises(UsageError, match=r"no recorded training: harness\.RecordRewards makes one"):
        load_study(tmp_path)


def test_a_damaged_recording_is_left_out(tmp_path):
    """The others are compared."""
    (two(tmp_path) / "plain-1" / "recording-0.json").write_text("{}")
    study = load_study(tmp_path)
    assert study.comparisons[0].seeds == (0,)
    (line,) = study.runs.damaged
    assert "plain-1" in line


def test_an_empty_recording_cuts_nobody(tmp_path):
    """It is left out."""
    record(two(tmp_path) / "empty", "plain", 5, [])
    study = load_study(tmp_path)
    assert study.runs.steps == len(RISING) * PULLS
    assert any("empty' is left out: it has no steps" in note for note in study.runs.notes)


def test_a_training_that_goes_on_is_told(tmp_path):
    """Its recording was not closed."""
    facts = tmp_path / "plain-0" / "recording-0.json"
    two(tmp_path)
    replace(TrainingFacts.read(facts), closed=False).write(facts)
    assert any(note.startswith("Still going on") and "plain-0" in note for note in load_study(tmp_path).runs.notes)


def test_learning_curves_of_every_measure_and_every_reward(study_folder):
    """Twenty points each, the mean over the episodes that ended in a stretch."""
    study = load_study(study_folder)
    learning = study.trainings.learning(study.comparisons[0])
    assert list(learning.random) == ["success", "arm", return_name("plain"), return_name("thrice")]
    points = learning.proposed.points["arm"]
    assert [point.steps for point in points] == [10 * (place + 1) for place in range(STRETCHES)]
    assert points[0].value.mean == pytest.approx(
        np.mean([np.linspace(0.0, 0.9 + 0.01 * s, 40)[:2].mean() for s in range(6)])
    )
    assert points[-1].value.low is not None


def test_batches_of_envs_have_episodes_of_their_own(tmp_path):
    """Two envs in turns: an episode is that of one env."""
    rows = [(env, 0, step) for step in range(3) for env in range(2)]
    env, episode, step = (np.array(column) for column in zip(*rows, strict=True))
    found = episodes_of(
        in_memory(
            TrainingFacts(rewards=("plain",), trained_with="plain", num_envs=2),
            {
                "env": env,
                "episode": episode,
                "reward/plain": np.array([1.0, 10.0, 2.0, 20.0, 3.0, 30.0]),
                "terminated": (step == 2) & (env == 0),
                "truncated": (step == 2) & (env == 1),
            },
        )
    )
    assert found.returns["plain"].tolist() == [6.0, 60.0]
    assert found.last.tolist() == [4, 5]


def test_trainings_without_the_end_of_an_episode_are_told(tmp_path):
    """With what to do."""
    two(tmp_path)
    record(tmp_path / "endless", "plain", 2, RISING, ends=False)
    (note,) = notes_of(tmp_path)
    assert note == "No episode ended in 1 of 3 trainings by plain: give the environment a time limit"


def test_cut_evaluations_are_told(tmp_path):
    """How many of all evaluation episodes of a reward were, and after how many steps."""
    two(tmp_path)
    for seed, cut in enumerate((0, 2)):
        facts = {"evaluation": True, "horizon": PULLS, "cut": cut}
        for reward in PAYS:
            record(
                tmp_path / f"{reward}-{seed}" / "e",
                reward,
                seed,
                RISING[:3],
                **{**facts, "cut": cut * (reward == "plain")},
            )
    (note,) = notes_of(tmp_path)
    assert note == "Policies trained by plain: 2 of 6 evaluation episodes were cut after 5 steps"


def apart(folder: Path, measure: str = "height", **facts) -> Path:
    """Three seeds whose measure, between -1 and 1, goes apart: the difference of both rewards is left open."""
    ends = {"plain": (-1.0, 0.0, 1.0), "thrice": (1.0, 0.0, -1.0)}
    for reward, of_seeds in ends.items():
        for seed, end in enumerate(of_seeds):
            behaviour = {measure: lambda arms, end=end: np.full_like(arms, end)}
            record(folder / f"{reward}-{seed}", reward, seed, RISING, behaviour=behaviour, **facts)
    return folder


def test_an_interval_stays_within_the_bounds_that_were_recorded(tmp_path):
    """The difference of two heights between -1 and 1 is 2 at most; so are the bands of learning."""
    study = load_study(apart(tmp_path, bounds={"height": (-1.0, 1.0)}))
    found = study.comparisons[0].decisive
    assert (found.low, found.high) == (-2.0, 2.0)
    band = study.trainings.learning(study.comparisons[0]).baseline.band("height")
    assert {(low, high) for _, low, high in band} == {(-1.0, 1.0)}


def test_without_bounds_an_interval_is_not_cut(tmp_path):
    """Nothing is known of the measure."""
    found = load_study(apart(tmp_path)).comparisons[0].decisive
    assert found.low < -2.2


def test_bounds_that_a_measure_left_are_told(tmp_path):
    """And cut nothing."""
    study = load_study(apart(tmp_path, bounds={"height": (0.0, 1.0)}))
    assert study.comparisons[0].decisive.low < -2.2
    (note,) = notes_of(tmp_path)
    assert note.startswith("height leaves its bounds, 0 to 1, in '")


def test_recordings_that_disagree_about_bounds_have_none(tmp_path):
    """Either may be wrong."""
    apart(tmp_path, bounds={"height": (-1.0, 1.0)})
    shutil.rmtree(tmp_path / "plain-0")
    behaviour = {"height": lambda arms: np.full_like(arms, -1.0)}
    record(tmp_path / "plain-0", "plain", 0, RISING, behaviour=behaviour, bounds={"height": (-2.0, 2.0)})
    assert load_study(tmp_path).comparisons[0].decisive.low < -2.2


@pytest.mark.parametrize(("measure", "cut"), [("success", True), ("height", False)])
def test_a_success_lies_between_0_and_1(tmp_path, measure, cut):
    """Also one that is a part of a success, as half of it; of another measure nobody knows."""
    for reward, of_seeds in {"plain": (0.0, 0.5, 1.0), "thrice": (1.0, 0.5, 0.0)}.items():
        for seed, end in enumerate(of_seeds):
            behaviour = {measure: lambda arms, end=end: np.full_like(arms, end)}
            record(tmp_path / f"{reward}-{seed}", reward, seed, RISING, behaviour=behaviour)
    found = load_study(tmp_path).comparisons[0].decisive
    assert found.measure.episodes is None
    assert (found.low == -1.0) == cut


@pytest.mark.parametrize("pay", [False, True])
def test_where_the_recorder_paid_a_copy_of_the_own_reward_is_known(tmp_path, pay):
    """Also in evaluations; else it is taken for what the env was made to pay."""
    pays = {"plain": PAYS["plain"], "copy": PAYS["plain"]}
    sources = {"reward_plain": Source("", OWN_SOURCE)}
    for seed in range(2):
        for reward in pays:
            path = record(tmp_path / f"{reward}-{seed}", reward, seed, RISING, pays=pays, sources=sources, pay=pay)
            record(path / "e", reward, seed, RISING, pays=pays, sources=sources, evaluation=True)
    (comparison,) = load_study(tmp_path).comparisons
    assert {manner: split.is_split for manner, split in comparison.number.returns.items()} == {
        EVALUATION: pay, LAST: pay, TRAINING: pay,
    }  # fmt: skip


def test_repr_is_a_line(study_folder):
    """A study holds every episode of every training; a notebook shows what it comes to."""
    study = load_study(study_folder)
    assert repr(study) == f"<Study of '{study_folder}': 12 trainings, 1 comparisons>"
    place = PlaceStudy(study.runs.group, (), study, "")
    assert len(repr(place).splitlines()) == 1
    assert len(repr(place)) < 300
    assert place._repr_html_() == study._repr_html_()
    assert "<table>" in study._repr_html_()


def test_place_without_a_study_shows_why(study_folder):
    """In place of the table."""
    place = PlaceStudy(load_study(study_folder).runs.group, (), None, "no seed < 2 is done")
    assert "no seed &lt; 2 is done" in place._repr_html_()


@pytest.fixture
def unlike(tmp_path):
    """Four trainings by one reward and three by the other, none of whose seeds is the same."""
    for seed in range(4):
        record(tmp_path / f"plain-{seed}", "plain", seed, np.linspace(0.0, 0.4 + 0.01 * seed, 40))
    for seed in range(10, 13):
        record(tmp_path / f"thrice-{seed}", "thrice", seed, np.linspace(0.0, 0.9 + 0.01 * seed, 40))
    return tmp_path


def test_trainings_without_a_common_seed_have_learning_curves(unlike):
    """All of them, as in the answer."""
    study = load_study(unlike)
    learning = study.trainings.learning(study.comparisons[0])
    assert [curve.points["arm"][0].value.seeds for curve in (learning.baseline, learning.proposed)] == [4, 3]


def test_trainings_without_a_common_seed_say_what_the_verdict_rests_on(unlike):
    """It does not need one."""
    (comparison,) = load_study(unlike).comparisons
    assert "rests on the training itself" in basis_text(comparison)


def test_the_smallest_p_is_that_of_both_numbers_of_trainings(unlike):
    """Four against three: one way in 35."""
    (told,) = load_study(unlike).to_json()["comparisons"]
    assert told["smallest_p"] == pytest.approx(1 / 35)


def test_an_unfinished_plan_has_no_verdict_yet(study_folder):
    """What it will rest on is told all the same."""
    (comparison,) = load_study(study_folder).comparisons
    assert basis_text(replace(comparison, answer=replace(comparison.answer, ruling=Ruling(missing=2)))).startswith(
        "The verdict will rest on the training"
    )
