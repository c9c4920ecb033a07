"""A folder of recordings: distances, what behaviour earned, and what is left out."""

from io import StringIO
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from harness.errors import UsageError
from harness.eta.rescaling import Rescaling
from harness.log import LogFacts, in_memory
from harness.log.open_log import Found
from harness_plugins.audit.audit import audit_table
from harness_plugins.audit.recorded.recordings import audit_logs, audit_recordings
from tests.results.recordings.conftest import PULLS, record


@pytest.fixture
def folder(tmp_path):
    """Three trainings of two rewards of which one counts otherwise, and one evaluation."""
    pays = {"plain": lambda a: a + 1.0, "square": lambda a: (a - 0.5) ** 2}
    for seed in range(3):
        record(tmp_path / f"runs/{seed}", "plain", seed, np.linspace(0.0, 0.9 + 0.01 * seed, 10), pays=pays)
    record(tmp_path / "runs/final", "plain", 0, [1.0, 1.0], pays=pays, evaluation=True)
    record(tmp_path / "random", "plain", 0, [0.0, 0.5], pays=pays, evaluation=True)
    return tmp_path


def test_distances_are_means_over_trainings(folder):
    """With an interval over them; evaluations do not enter."""
    (pair,) = audit_recordings(folder / "runs").pairs
    assert (pair.one, pair.other, len(pair.each)) == ("plain", "square", 3)
    assert pair.steps.mean == pytest.approx(np.mean([it.steps for it in pair.each]))
    assert 0.0 <= pair.steps.low < pair.steps.mean < pair.steps.high <= 1.0
    assert 0.0 < pair.discordant.mean < 1.0


def test_linear_rewards_are_no_distance_apart(study_folder):
    """One counts every pull as three of the other and 6."""
    (pair,) = audit_recordings(study_folder).pairs
    assert (pair.steps.mean, pair.returns.mean) == (pytest.approx(0.0, abs=1e-7), pytest.approx(0.0, abs=1e-7))
    assert (pair.discordant.mean, pair.largest) == (0.0, ())


def test_step_that_is_paid_most_differently_is_named(tmp_path):
    """Where one reward has an outlier that the other does not see."""
    pays = {"plain": lambda a: a, "spiked": lambda a: a + 100.0 * (a == 0.3)}
    record(tmp_path / "0", "plain", 0, [0.1, 0.2, 0.3, 0.4, 0.5, 0.6], pays=pays)
    (pair,) = audit_recordings(tmp_path).pairs
    first = pair.largest[0]
    assert len({(step.env, step.episode) for step in pair.largest}) == len(pair.largest) == 3
    assert (first.folder, first.env, first.episode, first.paid) == ("0", 0, 2, (0.3, pytest.approx(100.3)))


def test_early_and_late_behaviour_is_told_apart(folder):
    """Beside evaluations; each reward pays each."""
    early, late, final = audit_recordings(folder / "runs").earned
    assert [row.behaviour for row in (early, late, final)] == [
        "trained with plain, first fifth",
        "trained with plain, last fifth",
        "trained with plain, evaluations",
    ]
    assert early.returns["plain"].mean < late.returns["plain"].mean < final.returns["plain"].mean == 2.0 * PULLS
    assert (early.episodes, late.returns["square"].seeds) == (6, 3)


def test_random_actions_stand_first_where_they_are_given(folder):
    """Their interval is over episodes."""
    found = audit_recordings(folder / "runs", folder / "random")
    assert (found.earned[0].behaviour, found.earned[0].episodes) == ("random actions", 2)
    assert found.earned[0].returns["plain"].mean == pytest.approx(1.25 * PULLS)


def test_random_actions_in_the_same_folder_count_once(folder):
    """They are no evaluation of a policy then."""
    rows = [row.behaviour for row in audit_recordings(folder, folder / "random").earned]
    assert rows.count("random actions") == 1
    assert audit_recordings(folder, folder / "random").earned[-1].episodes == 2


def test_reward_that_was_given_up_is_left_out_there(tmp_path):
    """One line says where and why; the other training counts."""
    record(tmp_path / "0", "plain", 0, [0.1, 0.2, 0.3], failures={"reward/thrice": 7})
    record(tmp_path / "1", "plain", 1, [0.1, 0.2, 0.3])
    found = audit_recordings(tmp_path)
    (note,) = found.notes
    assert note == (
        "'0' does not count for reward 'thrice': given up in step 2 of episode 1: ZeroDivisionError: division by zero"
    )
    assert len(found.pairs[0].each) == 1


def test_rewards_that_no_recording_knows_together_are_told(tmp_path):
    """Their pair has no numbers."""
    record(tmp_path / "0", "a", 0, [0.1, 0.2], pays={"a": lambda a: a})
    record(tmp_path / "1", "b", 0, [0.1, 0.2], pays={"b": lambda a: a})
    found = audit_recordings(tmp_path)
    assert "No recording knows both 'a' and 'b'" in found.notes
    assert found.pairs[0].steps.mean is None


def test_damaged_recording_is_told(folder):
    """The others count."""
    (folder / "runs/1/recording-0.json").write_text("{")
    found = audit_recordings(folder / "runs")
    assert (len(found.damaged), found.facts["recordings"]) == (1, ["0", "2"])


@pytest.mark.parametrize("which", ["none", "two envs", "random of another env", "no step"])
def test_what_cannot_be_audited_is_one_line(tmp_path, which):
    """It says what was given and what to do."""
    runs, random = tmp_path / "runs", None
    runs.mkdir()
    told = "holds no recorded training"
    if which != "none":
        pays = {"plain": lambda a: a, "b": lambda a: -a}
        record(runs / "0", "plain", 0, [] if which == "no step" else [0.1, 0.2], pays=pays)
        told = "no recording in it has a step" if which == "no step" else "several envs"
    if which == "two envs":
        record(runs / "1", "plain", 1, [0.1], spec={"id": "Other-v0"})
    if which == "random of another env":
        random = record(tmp_path / "random", "plain", 0, [0.1], spec={"id": "Other-v0"}, evaluation=True)
    with pytest.raises(UsageError, match=told) as caught:
        audit_recordings(runs, random)
    assert "\n" not in str(caught.value)


def test_a_reward_that_is_another_but_for_its_scale_is_told(study_folder):
    """And on how many steps that was found."""
    found = audit_recordings(study_folder)
    (pair,) = found.pairs
    assert pair.rescaling == Rescaling(pytest.approx(3.0), pytest.approx(3.0), 12 * 40 * PULLS, None)
    assert found.to_json()["pairs"][0]["rescaled"] == pair.rescaling.to_json()
    text = StringIO()
    Console(file=text, width=200).print(audit_table(found))
    told = "thrice is 3 x plain + 3, in all 2,400 steps, for which plain paid more than 100 different numbers."
    assert told in text.getvalue()


def test_another_reward_has_no_such_line(folder):
    """It is at a distance."""
    assert audit_recordings(folder / "runs").pairs[0].rescaling is None


def test_behaviour_is_told_beside_what_it_earned(folder):
    """Every measure of the recordings, of random actions too; success decides."""
    found = audit_recordings(folder / "runs", folder / "random")
    random, early, late, final = found.earned
    assert [row.measures["success"].mean for row in (random, early, final)] == [0.0, 0.0, 1.0]
    assert 0.5 < late.measures["success"].mean <= 1.0
    assert final.measures["arm"].mean == 1.0
    assert found.success == "success"


def test_random_actions_of_an_experiment_are_no_policy(folder):
    """They lie among its evaluations, and a recording says how it acted: 800 episodes are not 900."""
    pays = {"plain": lambda a: a + 1.0, "square": lambda a: (a - 0.5) ** 2}
    for manner in ("deterministic", "stochastic"):
        for seed in range(2):
            place = folder / f"runs/{manner}-{seed}"
            record(place, "plain", seed, [0.9] * 4, pays=pays, evaluation=True, acted=manner)
    record(folder / "runs/by-chance", "plain", 0, [0.1] * 3, pays=pays, evaluation=True, acted="random")
    rows = {row.behaviour: row for row in audit_recordings(folder / "runs").earned}
    assert rows["random actions"].episodes == 3
    for manner in ("deterministic", "stochastic"):
        row = rows[f"trained with plain, {manner} evaluations"]
        assert (row.episodes, row.returns["plain"].seeds) == (8, 2)
        assert row.returns["plain"].mean == pytest.approx(1.9 * PULLS)


def test_evaluations_before_the_end_are_not_those_of_the_final_policy(folder):
    """They evaluate what the training left behind."""
    pays = {"plain": lambda a: a + 1.0, "square": lambda a: (a - 0.5) ** 2}
    record(folder / "runs/early", "plain", 1, [0.0] * 5, pays=pays, evaluation=True, after=10)
    assert audit_recordings(folder / "runs").earned[-1].episodes == 2


def test_a_reward_is_told_to_rank_episodes_as_success_does_or_not(tmp_path):
    """AUC by counting pairs: one pays the arm, which success follows; the other its opposite."""
    pays = {"plain": lambda a: a, "against": lambda a: -a}
    for seed in range(3):
        record(tmp_path / str(seed), "plain", seed, [0.1, 0.3, 0.6, 0.9], pays=pays)
    found = audit_recordings(tmp_path)
    assert {name: auc.value for name, auc in found.rankings.items()} == {"plain": 1.0, "against": 0.0}
    assert (found.rankings["plain"].above, found.rankings["plain"].clusters) == (6, 3)


def test_a_reward_that_pays_most_for_what_succeeds_less_is_named(folder):
    """With both behaviours and their success."""
    pays = {"plain": lambda a: a + 1.0, "square": lambda a: (a - 0.5) ** 2}
    record(folder / "runs/s", "square", 5, [0.9] * 5, pays=pays)
    record(folder / "runs/s-final", "square", 5, [0.0] * 5, pays=pays, evaluation=True)
    record(folder / "runs/p-final", "plain", 1, [0.8] * 5, pays=pays, evaluation=True)
    lines = audit_recordings(folder / "runs").verdict
    assert lines[0].startswith("plain pays most for what succeeds most: trained with plain, evaluations (success 1)")
    assert lines[1].startswith("square pays most for: trained with square, evaluations (success 0).")


def test_one_reward_alone_is_told_of(tmp_path):
    """Nothing stands beside it, and a line says what to do."""
    record(tmp_path / "0", "plain", 0, [0.1, 0.9], pays={"plain": lambda a: a})
    found = audit_recordings(tmp_path)
    assert (found.pairs, found.rewards, found.earned[-1].returns["plain"].mean) == ((), ("plain",), 0.9 * PULLS)
    assert "There is only one reward, plain" in found.notes[0]


def test_rewards_can_be_chosen(folder):
    """One that is not recorded is refused."""
    assert audit_recordings(folder / "runs", only=["square"]).rewards == ("square",)
    with pytest.raises(UsageError, match=r"No reward 'squar'\. There is: plain, square"):
        audit_recordings(folder / "runs", only=["squar"])


def monitored(path, place, pays):
    """A log of episodes."""
    facts = LogFacts(path=path / place, format="made", unit="episode")
    return in_memory(facts, {"reward/recorded": np.asarray(pays, float)})


def test_own_pay_of_logs_in_several_folders_is_of_several_rewards(tmp_path):
    """It cannot be compared, so each stands in a column of its own, and no pair has a number."""
    places = {"a/0.csv": np.arange(10.0), "a/1.csv": np.arange(10.0) + 1.0, "b/0.csv": np.arange(10.0)}
    logs = tuple(monitored(tmp_path, place, pays) for place, pays in places.items())
    found = audit_logs(tmp_path, Found(logs, ()))
    assert found.rewards == ("a", "b")
    late = {row.behaviour: row.returns for row in found.earned}["trained with a, last fifth"]
    assert (late["a"].mean, late["a"].seeds, late["b"].mean) == (9.0, 2, None)
    assert found.pairs[0].returns.mean is None
    assert "No recording knows both 'a' and 'b'" in found.notes
    assert found.notes[0] == "3 trainings of 2 rewards: `a` 2, `b` 1; the baseline is `a`"


def test_names_of_logs_are_sorted_as_the_user_says(tmp_path):
    """Here the folder is the seed."""
    logs = tuple(
        monitored(tmp_path, place, np.arange(10.0) + paid)
        for paid, place in enumerate(("0/a.csv", "1/a.csv", "1/b.csv"))
    )
    found = audit_logs(tmp_path, Found(logs, ()), sort="{seed}/{reward}")
    late = {row.behaviour: row.returns for row in found.earned}
    assert (late["trained with a, last fifth"]["a"].seeds, late["trained with b, last fifth"]["b"].seeds) == (2, 1)


def test_logs_of_one_folder_share_their_reward(tmp_path):
    """It is called as the folder is, as nobody says what it is."""
    log = monitored(tmp_path / "a", "0.csv", [1.0, 2.0])
    found = audit_logs(tmp_path / "a", Found((log,), ((Path("x"), "it is damaged"),)))
    assert (found.rewards, found.pairs) == (("a",), ())
    assert "'x' is left out: it is damaged" in found.notes


def test_folder_without_a_log_is_refused(tmp_path):
    """With what was left out."""
    with pytest.raises(UsageError, match=r"holds no log that is read: .* 'x' is left out: it is damaged"):
        audit_logs(tmp_path, Found((), ((Path("x"), "it is damaged"),)))


def test_steps_that_do_not_tell_where_episodes_end_are_compared(tmp_path):
    """By steps alone where there is no number of an episode either."""
    paid = {"reward/a": np.array([1.0, 2.0, 4.0]), "reward/b": np.array([-1.0, -2.0, -4.0])}
    log = in_memory(LogFacts(path=tmp_path / "steps.csv", format="made"), paid)
    (pair,) = audit_logs(tmp_path, Found((log,), ())).pairs
    assert (pair.steps.mean, pair.returns.mean) == (pytest.approx(1.0), None)


def test_evaluations_in_two_manners_are_of_one_training(tmp_path):
    """Intervals of how a reward ranks success are over trainings."""
    for seed in range(4):
        record(tmp_path / f"{seed}", "plain", seed, [0.2, 0.8])
        for manner in ("deterministic", "stochastic"):
            arms = [0.2, 0.8, 0.4, 0.6]
            record(tmp_path / f"{seed}-{manner}", "plain", seed, arms, evaluation=True, acted=manner)
    assert {it.clusters for it in audit_recordings(tmp_path).rankings.values()} == {4}
