"""A folder of recordings: distances, what behaviour earned, and what is left out."""

from io import StringIO
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from harness.log import LogFacts, in_memory
from harness.log.open_log import Found
from harness_plugins.audit import audit_logs, audit_recordings, audit_table
from tests.refusals import refused
from tests.results.recordings.conftest import PULLS, record

PAYS = {"plain": lambda a: a + 1.0, "square": lambda a: (a - 0.5) ** 2}


def ended(place, seed, arms, reward="plain", **how):
    """An evaluation of both rewards."""
    return record(place, reward, seed, arms, pays=PAYS, evaluation=True, **how)


@pytest.fixture
def folder(tmp_path):
    """Three trainings of two rewards of which one counts otherwise, and one evaluation."""
    for seed in range(3):
        record(tmp_path / f"runs/{seed}", "plain", seed, np.linspace(0.0, 0.9 + 0.01 * seed, 10), pays=PAYS)
    ended(tmp_path / "runs/final", 0, [1.0, 1.0])
    ended(tmp_path / "random", 0, [0.0, 0.5])
    return tmp_path


def test_distances_are_means_over_trainings(folder):
    """With an interval over them; evaluations do not enter. Another reward is no rescaling."""
    (pair,) = audit_recordings(folder / "runs").pairs
    assert (pair.one, pair.other, len(pair.each)) == ("plain", "square", 3)
    assert pair.steps.value == pytest.approx(np.mean([it.steps for it in pair.each]))
    assert 0.0 <= pair.steps.low < pair.steps.value < pair.steps.high <= 1.0
    assert 0.0 < pair.discordant.value < 1.0
    assert pair.rescaling is None


def test_step_that_is_paid_most_differently_is_named(tmp_path):
    """Where one reward has an outlier that the other does not see."""
    pays = {"plain": lambda a: a, "spiked": lambda a: a + 100.0 * (a == 0.3)}
    record(tmp_path / "0", "plain", 0, [0.1, 0.2, 0.3, 0.4, 0.5, 0.6], pays=pays)
    (pair,) = audit_recordings(tmp_path).pairs
    first = pair.largest[0]
    assert len({(step.env, step.episode) for step in pair.largest}) == len(pair.largest) == 3
    assert (first.folder, first.env, first.episode, first.paid) == ("0", 0, 2, (0.3, pytest.approx(100.3)))


def test_early_and_late_behaviour_is_told_apart(folder):
    """Behind random actions, whose interval is over episodes, and before evaluations; each reward pays each.

    With every measure of the recordings; success decides.
    """
    found = audit_recordings(folder / "runs", folder / "random")
    names = ["random actions", *(f"trained with plain, {it}" for it in ("first fifth", "last fifth", "evaluations"))]
    assert [row.behaviour for row in found.earned] == names
    random, early, late, final = (row.returns["plain"].value for row in found.earned)
    assert random == pytest.approx(1.25 * PULLS)
    assert early < late < final == 2.0 * PULLS
    random, early, late, final = found.earned
    assert (random.episodes, early.episodes, late.returns["square"].seeds) == (2, 6, 3)
    assert [row.measures["success"].value for row in (random, early, final)] == [0.0, 0.0, 1.0]
    assert 0.5 < late.measures["success"].value <= 1.0
    assert (final.measures["arm"].value, found.success) == (1.0, "success")


def test_random_actions_in_the_same_folder_count_once(folder):
    """They are no evaluation of a policy then."""
    rows = audit_recordings(folder, folder / "random").earned
    assert [row.behaviour for row in rows].count("random actions") == 1
    assert rows[-1].episodes == 2


def test_reward_that_was_given_up_is_left_out_there(tmp_path):
    """One line says where and why; the other training counts."""
    for seed, failures in enumerate(({"reward/thrice": 7}, {})):
        record(tmp_path / f"{seed}", "plain", seed, [0.1, 0.2, 0.3], failures=failures)
    found = audit_recordings(tmp_path)
    why = "given up in step 2 of episode 1: ZeroDivisionError: division by zero"
    assert found.notes == (f"'0' does not count for reward 'thrice': {why}",)
    assert len(found.pairs[0].each) == 1


def test_rewards_that_no_recording_knows_together_are_told(tmp_path):
    """Their pair has no numbers."""
    for seed, name in enumerate("ab"):
        record(tmp_path / name, name, seed, [0.1, 0.2], pays={name: lambda a: a})
    found = audit_recordings(tmp_path)
    assert "No recording knows both 'a' and 'b'" in found.notes
    assert found.pairs[0].steps.value is None


def test_damaged_recording_is_told(folder):
    """The others count."""
    (folder / "runs/1/recording-0.json").write_text("{")
    found = audit_recordings(folder / "runs")
    assert (len(found.damaged), found.facts["recordings"]) == (1, ["0", "2"])


OTHER = {"spec": {"id": "Other-v0"}}
REFUSED = {
    "none": ([], "holds no recorded training"),
    "no step": ([("runs/0", [], {})], "no recording in it has a step"),
    "two envs": ([("runs/0", [0.1], {}), ("runs/1", [0.1], OTHER)], "several envs"),
    "random of another env": (
        [("runs/0", [0.1], {}), ("random", [0.1], {**OTHER, "evaluation": True})],
        "several envs",
    ),
}


@pytest.mark.parametrize(("recorded", "told"), REFUSED.values(), ids=REFUSED)
def test_what_cannot_be_audited_is_one_line(tmp_path, recorded, told):
    """It says what was given and what to do."""
    (tmp_path / "runs").mkdir()
    for seed, (place, arms, how) in enumerate(recorded):
        record(tmp_path / place, "plain", seed, arms, pays=PAYS, **how)
    random = tmp_path / "random"
    with refused(told):
        audit_recordings(tmp_path / "runs", random if random.exists() else None)


def test_a_reward_that_is_another_but_for_its_scale_is_told(study_folder):
    """At no distance: one counts every pull as three of the other and 6. And on how many steps that was found."""
    found = audit_recordings(study_folder)
    (pair,), zero = found.pairs, pytest.approx(0.0, abs=1e-7)
    assert (pair.steps.value, pair.returns.value, pair.discordant.value, pair.largest) == (zero, zero, 0.0, ())
    line = pair.rescaling
    assert (line.factor, line.offset, line.steps) == (pytest.approx(3.0), pytest.approx(3.0), 12 * 40 * PULLS)
    assert found.to_json()["pairs"][0]["rescaled"] == line.to_json()
    text = StringIO()
    Console(file=text, width=200).print(audit_table(found))
    told = "thrice is 3 x plain + 3, in all 2,400 steps, for which plain paid more than 100 different numbers."
    assert told in text.getvalue()


def test_random_actions_of_an_experiment_are_no_policy(folder):
    """They lie among its evaluations, and a recording says how it acted: 800 episodes are not 900.

    Evaluations before the end evaluate what the training left behind, and not its final policy.
    """
    manners = ("deterministic", "stochastic")
    for manner in manners:
        for seed in range(2):
            ended(folder / f"runs/{manner}-{seed}", seed, [0.9] * 4, acted=manner)
    ended(folder / "runs/by-chance", 0, [0.1] * 3, acted="random")
    ended(folder / "runs/early", 1, [0.0] * 5, after=10)
    rows = {row.behaviour: row for row in audit_recordings(folder / "runs").earned}
    assert (rows["random actions"].episodes, rows["trained with plain, evaluations"].episodes) == (3, 2)
    for manner in manners:
        row = rows[f"trained with plain, {manner} evaluations"]
        assert (row.episodes, row.returns["plain"].seeds) == (8, 2)
        assert row.returns["plain"].value == pytest.approx(1.9 * PULLS)


def test_a_reward_is_told_to_rank_episodes_as_success_does_or_not(tmp_path):
    """AUC by counting pairs: one pays the arm, which success follows; the other its opposite."""
    pays = {"plain": lambda a: a, "against": lambda a: -a}
    for seed in range(3):
        record(tmp_path / str(seed), "plain", seed, [0.1, 0.3, 0.6, 0.9], pays=pays)
    rankings = audit_recordings(tmp_path).rankings
    assert {name: auc.value for name, auc in rankings.items()} == {"plain": 1.0, "against": 0.0}
    assert (rankings["plain"].above, rankings["plain"].clusters) == (6, 3)


def test_a_reward_that_pays_most_for_what_succeeds_less_is_named(folder):
    """With both behaviours and their success. What earned most is marked."""
    record(folder / "runs/s", "square", 5, [0.9] * 5, pays=PAYS)
    ended(folder / "runs/s-final", 5, [0.0] * 5, "square")
    ended(folder / "runs/p-final", 1, [0.8] * 5)
    found = audit_recordings(folder / "runs")
    assert found.verdict[0].startswith(
        "plain pays most for what succeeds most: trained with plain, evaluations (success 1"
    )
    assert found.verdict[1].startswith("square pays most for: trained with square, evaluations (success 0).")
    assert str(found).count("(most)") == 2


def test_one_reward_alone_is_told_of(tmp_path):
    """Nothing stands beside it, and a line says what to do."""
    record(tmp_path / "0", "plain", 0, [0.1, 0.9], pays={"plain": lambda a: a})
    found = audit_recordings(tmp_path)
    assert (found.pairs, found.rewards, found.earned[-1].returns["plain"].value) == ((), ("plain",), 0.9 * PULLS)
    assert "There is only one reward, plain" in found.notes[0]


def test_rewards_can_be_chosen(folder):
    """One that is not recorded is refused."""
    assert audit_recordings(folder / "runs", only=["square"]).rewards == ("square",)
    with refused(r"No reward 'squar'\. There is: plain, square"):
        audit_recordings(folder / "runs", only=["squar"])


@pytest.fixture
def logged(tmp_path):
    """The audit of logs of episodes, by place; and what was left out."""

    def ask(places, at=".", left_out=(), **how):
        logs = [
            in_memory(LogFacts(path=tmp_path / place, format="made", unit="episode"), {"reward/recorded": paid})
            for place, paid in places.items()
        ]
        return audit_logs(tmp_path / at, Found(tuple(logs), left_out), **how)

    return ask


TEN, DAMAGED = np.arange(10.0), ((Path("x"), "it is damaged"),)


def test_own_pay_of_logs_in_several_folders_is_of_several_rewards(logged):
    """It cannot be compared, so each stands in a column of its own, and no pair has a number."""
    found = logged({"a/0.csv": TEN, "a/1.csv": TEN + 1.0, "b/0.csv": TEN})
    assert (found.rewards, found.pairs[0].returns.value) == (("a", "b"), None)
    late = {row.behaviour: row.returns for row in found.earned}["trained with a, last fifth"]
    assert (late["a"].value, late["a"].seeds, late["b"].value) == (9.0, 2, None)
    assert "No recording knows both 'a' and 'b'" in found.notes
    assert found.notes[0] == "3 trainings of 2 rewards: `a` 2, `b` 1; the baseline is `a`"


def test_names_of_logs_are_sorted_as_the_user_says(logged):
    """Here the folder is the seed."""
    found = logged({"0/a.csv": TEN, "1/a.csv": TEN + 1.0, "1/b.csv": TEN + 2.0}, sort="{seed}/{reward}")
    late = {row.behaviour: row.returns for row in found.earned}
    assert [late[f"trained with {it}, last fifth"][it].seeds for it in "ab"] == [2, 1]


def test_logs_of_one_folder_share_their_reward(logged):
    """It is called as the folder is, as nobody says what it is; what is missing is told, and holds back the verdict."""
    found = logged({"a/0.csv": np.array([1.0, 2.0])}, "a", DAMAGED)
    assert (found.rewards, found.pairs, found.verdict) == (("a",), (), ("Interim: 1 training missing.",))
    assert "'x' is missing: it is damaged" in found.notes
    assert logged({"a/0.csv": np.array([1.0, 2.0])}, "a", DAMAGED, leave_out=[Path("x")]).verdict == ()
    with refused(r"holds no log that is read: .* 'x' cannot be read: it is damaged"):
        logged({}, left_out=DAMAGED)


def test_steps_that_do_not_tell_where_episodes_end_are_compared(tmp_path):
    """By steps alone where there is no number of an episode either."""
    paid = {f"reward/{name}": sign * np.array([1.0, 2.0, 4.0]) for name, sign in (("a", 1.0), ("b", -1.0))}
    log = in_memory(LogFacts(path=tmp_path / "steps.csv", format="made"), paid)
    (pair,) = audit_logs(tmp_path, Found((log,), ())).pairs
    assert (pair.steps.value, pair.returns.value) == (pytest.approx(1.0), None)


def test_evaluations_in_two_manners_are_of_one_training(tmp_path):
    """Intervals of how a reward ranks success are over trainings."""
    for seed in range(4):
        record(tmp_path / f"{seed}", "plain", seed, [0.2, 0.8])
        for manner in ("deterministic", "stochastic"):
            arms = [0.2, 0.8, 0.4, 0.6]
            record(tmp_path / f"{seed}-{manner}", "plain", seed, arms, evaluation=True, acted=manner)
    assert {it.clusters for it in audit_recordings(tmp_path).rankings.values()} == {4}
