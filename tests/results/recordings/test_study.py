from dataclasses import replace

import numpy as np
import pytest

from harness import load_results
from harness.errors import UsageError
from harness.eta import Ruling
from harness.record import TrainingFacts
from harness.record.recording.facts import OWN_SOURCE, Source
from harness.report import basis_text
from harness.results.compare import compare_all
from harness.results.logs.told import Deciding, Told
from tests.results.recordings.conftest import PAYS, PULLS, load_study, paid_in, record

RISING = np.linspace(0.0, 1.0, 20)
TRAINING, LAST, EVALUATION = "over the training", "in its last fifth", "in evaluations"


@pytest.fixture(name="study_of")
def _study_of(tmp_path):
    """The study of trainings with two rewards, two seeds each, and of some beside them: name, reward, seed, facts."""

    def study(*beside, seeds=2, **facts):
        both = [(f"{reward}-{seed}", reward, seed, facts) for seed in range(seeds) for reward in ("plain", "thrice")]
        for name, reward, seed, more in (*both, *beside):
            record(tmp_path / name, reward, seed, **{"arms": RISING + 0.01 * (seed or 0), **more})
        return load_study(tmp_path)

    return study


ALIKE = ("The trainings by plain ", "thrice is 3 x plain + 3, in all")
"""What is told of most studies here: trainings are equal bit for bit, and rewards differ in scale and offset alone."""


def read_of(results):
    """What was read of the only group."""
    (trainings,) = results.trainings
    return trainings.read


def notes_of(study):
    """All other notes."""
    return [note for note in read_of(study).notes if not note.startswith(ALIKE)]


def test_without_evaluations_the_verdict_says_that_it_rests_on_training(study_folder):
    """On its last part, and how to do better."""
    (comparison,) = load_study(study_folder).combinations
    assert comparison.manner == LAST
    assert "rests on the training itself" in basis_text(comparison)
    assert "harness.evaluate_policy" in basis_text(comparison)


def test_evaluations_that_are_not_there_for_all_do_not_decide(study_folder):
    """One of twelve is told, and the training decides."""
    record(study_folder / "plain-0" / "evaluation", "plain", 0, [0.2, 0.3], evaluation=True)
    study = load_study(study_folder)
    assert study.combinations[0].manner == LAST
    assert "11 of 12 trainings have no evaluation beside them" in read_of(study).notes
    assert paid_in(study, EVALUATION)["plain", "plain"].value == pytest.approx(PULLS * 1.25)


@pytest.mark.parametrize(
    ("facts", "told"),
    [
        (
            ("plain-0/lost", "plain", 7, {"arms": [0.1], "evaluation": True}),
            "it evaluates plain of seed 7, whose training",
        ),
        (
            ("endless", "plain", 2, {"ends": False}),
            "No episode ended in 1 of 3 trainings by plain: give the environment a",
        ),
        (
            ("short", "plain", 2, {"ends": False, "spec": {"id": "Bandit-v0", "max_episode_steps": 500}}),
            "train for 500 steps or more: an episode takes up to 500, and each of 1 env took 100",
        ),
        (
            ("other", "plain", 5, {"spec": {"id": "Bandit-v0", "kwargs": {"reward": "plain"}}}),
            "different arguments: {'reward': 'plain'} and {}",
        ),
    ],
    ids=["its training is gone", "no end of an episode", "its budget is shorter", "other arguments"],
)
def test_an_odd_recording_is_told(study_of, facts, told):
    """In one line, and the others are compared."""
    study = study_of(facts)
    (note,) = notes_of(study)
    assert told in note
    assert read_of(study).steps == len(RISING) * PULLS


def test_chosen_measures_are_compared_alone(study_folder):
    """Beside the one that decides."""
    assert load_study(study_folder, metrics="success").measures == ("success",)
    assert load_study(study_folder, metrics=["arm"]).measures == ("success", "arm")


def test_measure_that_is_not_recorded_is_refused(study_folder):
    """With those that are."""
    with pytest.raises(UsageError, match=r"No measure 'leg'\. There is: arm, success"):
        _ = load_study(study_folder, metrics="leg").combinations


def test_an_unfinished_episode_does_not_count(study_of):
    """A training that is cut in the middle of an episode has the mean of those before."""
    assert read_of(study_of()).members["plain", 0].parts(PULLS * 2 + 3)[TRAINING].episodes == 2


def test_signs_of_the_summed_curve_decide_which_indices_there_are(study_of):
    """A sum that is always negative has I_N alone."""
    (comparison,) = study_of(pays={"plain": lambda arm: arm - 2.0, "thrice": lambda arm: arm - 4.0}).combinations
    assert list(comparison.number.index_splits) == ["eta_N"]


def test_studies_of_one_experiment_are_one_family(tmp_path):
    """The claims of all groups of trainings are corrected together: none is more significant than alone."""
    for group in ("first", "second"):
        for reward, arms in (("plain", RISING), ("thrice", [1.0 - arm for arm in RISING])):
            for seed in range(5):
                record(tmp_path / group / f"{reward}-{seed}", reward, seed, [arm + 0.01 * seed for arm in arms])
    alone = load_study(tmp_path / "first")
    groups = [load_study(tmp_path / group).trainings[0] for group in ("first", "second")]
    together = compare_all([(it, it.match("plain", "thrice")) for it in groups])
    count = alone.combinations[0].answer.claims
    assert count > 1
    assert [it.answer.claims for it in together] == [2 * count, 2 * count]
    pairs = zip(alone.combinations[0].measured.changes, together[0].measured.changes, strict=True)
    hints = [
        (one.corrected, both.corrected) for one, both in pairs if one.corrected is not None and one.is_plain is None
    ]
    assert hints
    assert all(of_all >= of_one for of_one, of_all in hints)


def test_measures_are_as_they_were_recorded(study_of):
    """Of one less may be better; one of zeros and ones is a share, whose interval knows of the episodes."""
    (comparison,) = study_of(lower_is_better=("arm",)).combinations
    told = {it.name: (it.measure.better, it.measure.episodes) for it in comparison.measured.changes_of(LAST)}
    assert told == {"success": ("higher", 4), "arm": ("lower", None)}


def test_without_behaviour_rewards_alone_decide_nothing(study_of):
    """The number is told, the agent is not judged."""
    headline = study_of(behaviour={}).combinations[0].headline
    assert headline.answer.value == "cannot tell"
    assert headline.robot.startswith("How the robot behaves was not measured")
    assert "times as much" in headline.number


def test_longer_trainings_are_cut_to_the_shortest(study_of):
    """It is told which that is."""
    study = study_of(("short", "plain", 9, {"arms": RISING[:10], "asked": 10 * PULLS}), ("long", "thrice", 9, {}))
    assert read_of(study).steps == 10 * PULLS
    assert read_of(study).members["thrice", 9].parts(read_of(study).steps)[TRAINING].episodes == 10
    assert any("cut to the 50 steps of the shortest" in note and "short" in note for note in read_of(study).notes)


def odd(trained_with, **facts):
    """A third seed of both rewards, and what is odd about the training by one."""
    other = {"plain": "thrice", "thrice": "plain"}[trained_with]
    return ("odd", trained_with, 2, facts), ("even", other, 2, {})


@pytest.mark.parametrize(
    ("facts", "reason"),
    [
        ({"failures": {"reward/thrice": 12}}, "given up in step 2 of episode 2: ZeroDivisionError"),
        ({"pays": {"plain": PAYS["plain"]}}, "odd': not recorded"),
    ],
    ids=["given up", "not recorded"],
)
def test_a_reward_that_one_training_does_not_know_cannot_pay_it(study_of, facts, reason):
    """No split, with the reason; each training's own return is there."""
    study = study_of(*odd("plain", **facts))
    split = study.combinations[0].number.returns[TRAINING]
    assert not split.is_split
    assert reason in split.ratio.ruler.note
    assert split.ratio.eta.value is not None
    assert "1 of 3 seeds have none" in paid_in(study, TRAINING)["thrice", "plain"].note


def test_an_own_reward_that_was_given_up_leaves_no_return(study_of):
    """The reason stands in place of the number; the behaviour is judged all the same."""
    (comparison,) = study_of(*odd("thrice", failures={"reward/thrice": 12})).combinations
    assert (comparison.number.returns, comparison.number.decomposition) == ({}, None)
    assert "given up" in comparison.number.sentence(comparison.names)
    assert comparison.decisive.seeds == 3


def test_a_share_that_was_given_up_in_one_training_stays_a_share(study_of):
    """Of the trainings that have it."""
    decisive = study_of(*odd("thrice", failures={"behaviour/success": 12})).combinations[0].decisive
    assert (decisive.counts, decisive.without, decisive.measure.episodes) == ((3, 2), (0, 1), 4)
    assert "given up in step 2 of episode 2" in decisive.reason


@pytest.mark.parametrize("pay", [False, True])
def test_where_the_recorder_paid_a_copy_of_the_own_reward_is_known(study_of, pay):
    """Also in evaluations; else what the env pays is taken for what it was made to pay, another in each training."""
    facts = {
        "pays": {"plain": PAYS["plain"], "copy": PAYS["plain"]},
        "sources": {"reward_plain": Source("", OWN_SOURCE)},
    }
    trained = [
        (f"{reward}{seed}", reward, seed, {**facts, "pay": pay}) for seed in range(2) for reward in facts["pays"]
    ]
    evaluated = [(f"{name}/e", reward, seed, {**facts, "evaluation": True}) for name, reward, seed, _ in trained]
    (comparison,) = study_of(*trained, *evaluated, seeds=0).combinations
    splits = comparison.number.returns
    assert {manner: it.is_split for manner, it in splits.items()} == dict.fromkeys((EVALUATION, LAST, TRAINING), pay)
    assert pay or "that was copy here" in splits[TRAINING].ratio.ruler.note


def test_code_that_changed_between_trainings_is_told(study_of):
    """A reward of one name has to be one reward."""
    same = Source("", "the same")
    of = [{"sources": {"reward_plain": Source("", text), "reward_thrice": same}} for text in ("return 1", "return 2")]
    study = study_of(*((f"{it}{seed}", it, seed, of[seed]) for seed in range(2) for it in PAYS), seeds=0)
    assert "The code of reward plain is not the same in" in "".join(notes_of(study))


def test_an_evaluation_may_lack_a_measure(study_of):
    """It is n/a there, with the reason."""
    lacks = {"arms": [0.1], "evaluation": True, "behaviour": {}}
    study = study_of(*((f"{reward}-{seed}/e", reward, seed, lacks) for seed in range(2) for reward in PAYS))
    (comparison,) = study.combinations
    assert comparison.manner == EVALUATION
    assert "success is not known: success in " in comparison.headline.robot
    assert "not recorded" in comparison.headline.robot


def test_of_seeds_that_only_one_reward_has_behaviour_is_compared(study_of):
    """What is paid is compared on the seeds of both."""
    study = study_of(("more", "plain", 8, {}))
    found = study.combinations[0]
    assert (found.seeds, found.trained) == ((0, 1), ((0, 1, 8), (0, 1)))
    assert found.decisive.counts == (3, 2)
    assert paid_in(study, TRAINING)["plain", "plain"].seeds == 3


def test_trainings_without_a_seed_are_numbered(study_of):
    """In the order of their folders."""
    study = study_of(*((name, reward, None, {}) for name, reward in zip("abcd", [*PAYS] * 2, strict=True)), seeds=0)
    assert sorted(read_of(study).members) == [("plain", 0), ("plain", 1), ("thrice", 0), ("thrice", 1)]
    assert "4 trainings recorded without a seed" in read_of(study).notes[0]


@pytest.mark.parametrize(
    ("beside", "told"),
    [
        (("again", "plain", 1, {}), r"'again' was trained with plain and seed 1 too: .*--leave-out .*plain-1"),
        (
            ("other", "plain", 5, {"spec": {"id": "Other-v1"}}),
            r"mixes trainings in several envs: Other-v1 .*Bandit-v0",
        ),
    ],
)
def test_what_is_not_one_study_is_refused(study_of, beside, told):
    """Two trainings of one seed, several envs: folders of each are named."""
    with pytest.raises(UsageError, match=told):
        study_of(beside)


def test_a_training_that_goes_on_is_missing(study_of, tmp_path):
    """Its recording was not closed."""
    study_of()
    facts = tmp_path / "plain-0" / "recording-0.json"
    replace(TrainingFacts.read(facts), closed=False).write(facts)
    study = load_study(tmp_path)
    assert f"'{tmp_path / 'plain-0'}' is missing: it is still going on, or was killed" in read_of(study).notes
    assert [comparison.headline.answer for comparison in study.combinations] == ["interim"] * len(study.combinations)


def test_learning_curves_of_every_measure_and_every_reward(study_folder):
    """Twenty points each, the mean over the episodes that ended in a stretch."""
    study = load_study(study_folder)
    learning = study.learning(study.combinations[0])
    assert list(learning.random) == ["success", "arm", "return paid by plain", "return paid by thrice"]
    points = learning.curves[1].points["arm"]
    assert [point.steps for point in points] == [10 * (place + 1) for place in range(20)]
    assert points[0].mean.value == pytest.approx(
        np.mean([np.linspace(0.0, 0.9 + 0.01 * s, 40)[:2].mean() for s in range(6)])
    )
    assert points[-1].mean.low is not None


def test_cut_evaluations_are_told(study_of):
    """How many of all evaluation episodes of a reward were, and after how many steps."""
    facts = {"evaluation": True, "horizon": PULLS, "arms": RISING[:3]}
    evaluated = [("plain", 0, 0), ("plain", 1, 2), ("thrice", 0, 0), ("thrice", 1, 0)]
    study = study_of(*((f"{it}-{seed}/e", it, seed, {**facts, "cut": cut}) for it, seed, cut in evaluated))
    assert notes_of(study) == ["Policies trained by plain: 2 of 6 evaluation episodes were cut after 5 steps"]


def ending(ends, measure="height", **facts):
    """Trainings by both rewards, at which a measure ends so in each seed: it leaves the difference open."""
    told = {"higher_is_better": ("height",), **facts}
    return [
        (f"{it}-{seed}", it, seed, {"behaviour": {measure: lambda arms, end=end: np.full_like(arms, end)}, **told})
        for it, of_seeds in {"plain": ends, "thrice": ends[::-1]}.items()
        for seed, end in enumerate(of_seeds)
    ]


def test_an_interval_stays_within_the_bounds_that_were_recorded(study_of):
    """The difference of two heights between -1 and 1 is 2 at most; so are the bands of learning."""
    study = study_of(*ending((-1.0, 0.0, 1.0), bounds={"height": (-1.0, 1.0)}), seeds=0)
    found = study.combinations[0].decisive
    assert (found.low, found.high) == (-2.0, 2.0)
    band = study.learning(study.combinations[0]).curves[0].band("height")
    assert {(low, high) for _, low, high in band} == {(-1.0, 1.0)}


@pytest.mark.parametrize(
    ("bounds", "other", "told"),
    [
        ({}, {}, False),
        ({"height": (0.0, 1.0)}, {"height": (0.0, 1.0)}, True),
        ({"height": (-1.0, 1.0)}, {"height": (-2.0, 2.0)}, False),
    ],
    ids=["none", "that the measure left", "that differ"],
)
def test_bounds_that_do_not_hold_cut_nothing(study_of, bounds, other, told):
    """Where none are recorded, where recordings disagree about them, and where the measure left them, which is told."""
    first, *rest = ending((-1.0, 0.0, 1.0), bounds=bounds)
    study = study_of((*first[:3], {**first[3], "bounds": other}), *rest, seeds=0)
    assert study.combinations[0].decisive.low < -2.2
    assert [note.startswith("height leaves its bounds, 0 to 1, in '") for note in notes_of(study)] == [True] * told


@pytest.mark.parametrize(("measure", "cut"), [("success", True), ("height", False)])
def test_a_success_lies_between_0_and_1(study_of, measure, cut):
    """Also one that is a part of a success, as half of it; of another measure nobody knows."""
    found = study_of(*ending((0.0, 0.5, 1.0), measure), seeds=0).combinations[0].decisive
    assert found.measure.episodes is None
    assert (found.low == -1.0) == cut


def test_a_measure_that_decides_has_a_direction(study_of, tmp_path):
    """The recordings tell it, or the user does, whose word counts; else it is asked."""
    trainings = ending((-1.0, 0.0, 1.0), higher_is_better=())
    with pytest.raises(UsageError, match="say --measure height:better=lower or --measure height:better=higher"):
        study_of(*trainings, seeds=0)
    found = load_results(tmp_path, told=Told(deciding=Deciding("height", "lower"))).combinations[0].decisive
    assert (found.name, found.measure.better) == ("height", "lower")
    with pytest.raises(UsageError, match="--measure depth: the recordings tell height"):
        load_results(tmp_path, told=Told(deciding=Deciding("depth", "lower")))


def test_trainings_that_say_the_contrary_give_a_measure_no_direction(study_of, tmp_path):
    """Whatever their folders are called; the user's word counts."""
    trainings = ending((-1.0, 0.0, 1.0))
    trainings[0][3].update(higher_is_better=(), lower_is_better=("height",))
    with pytest.raises(
        UsageError, match=r"'height' decides, and nobody says .*, or both are said: say --measure height:"
    ):
        study_of(*trainings, seeds=0)
    found = load_results(tmp_path, told=Told(deciding=Deciding("height", "lower"))).combinations[0].decisive
    assert found.measure.better == "lower"


def test_trainings_whose_first_measures_differ_are_asked_which_one_decides(study_of, tmp_path):
    """None decides because a folder is called so."""
    did = {"arm": lambda arms: arms, "success": lambda arms: (arms > 0.5) * 1.0}
    with pytest.raises(UsageError, match=r"trainings name several: success .*, arm .*--measure NAME says which"):
        study_of(("thrice-9", "thrice", 9, {"behaviour": did}))
    assert load_results(tmp_path, told=Told(deciding=Deciding("success"))).combinations[0].decisive.name == "success"


@pytest.mark.parametrize(("named", "offered"), [("", ()), ("success", ()), ("arm", ("success",))])
def test_a_measure_named_later_is_one_of_all(study_of, tmp_path, named, offered):
    """The one that decides by itself was named before, whoever names it again. What is not shown counts too."""
    study_of(seeds=3)
    found = load_results(tmp_path, metrics=named or None, told=Told(deciding=Deciding(named, "higher" * bool(named))))
    (comparison,) = found.combinations
    assert (comparison.measured.offered, comparison.answer.ruling.offered) == (offered, len(offered))


def test_trainings_without_a_common_seed_are_compared(study_of):
    """By four trainings against three: the answer needs no common seed, nor do learning curves; one way in 35.

    That nothing else is compared is said.
    """
    given = [("plain", range(4), 0.4), ("thrice", range(10, 13), 0.9)]
    study = study_of(
        *((f"{it}{s}", it, s, {"arms": RISING * end + 0.01 * s}) for it, of, end in given for s in of), seeds=0
    )
    (comparison,) = study.combinations
    assert comparison.decisive.counts == (4, 3)
    assert "no seed is done under both plain and thrice" in comparison.number.sentence(comparison.names)
    learning = study.learning(comparison)
    assert [curve.points["arm"][0].mean.seeds for curve in learning.curves] == [4, 3]
    assert "rests on the training itself" in basis_text(comparison)


def test_an_unfinished_plan_has_no_verdict_yet(study_folder):
    """What it will rest on is told all the same."""
    (comparison,) = load_study(study_folder).combinations
    assert basis_text(replace(comparison, answer=replace(comparison.answer, ruling=Ruling(missing="2")))).startswith(
        "The verdict will rest on the training"
    )
