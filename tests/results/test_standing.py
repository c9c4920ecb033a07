"""How an experiment with looks stands, from folders made by hand."""

from dataclasses import replace

import pytest

from harness.record import Terms
from harness.results.comparison import Seen
from harness.results.results import standing_of, told_manifests
from tests.results.folders import fail
from tests.results.in_looks import REWARDS

TERMS = Terms((2, 4, 6), asked=2, margin=0.1)
WIDE = replace(TERMS, margin=0.7)
"""Four trainings that end alike are enough to say that a difference is below this."""


def test_at_first_all_rewards_wait_for_the_first_look(folder_of):
    """Two seeds of each."""
    standing = folder_of(TERMS).standing
    assert standing.open == REWARDS
    assert (standing.look, len(standing.next)) == (0, 6)
    assert standing.most_left == 18
    assert standing.text == "0 of 2 decided, at most 18 trainings left"


@pytest.mark.parametrize(
    ("trained", "failed", "look"),
    [
        ({"baseline": 2, "dense": 2, "arp": 2}, 0, 1),
        ({"baseline": 2, "dense": 1}, 0, 0),
        ({"baseline": 2, "dense": 2}, 2, 1),
    ],
    ids=["all", "some", "others failed"],
)
def test_a_look_is_over_when_all_of_its_cells_have_ended(folder_of, trained, failed, look):
    """Then the next one comes: nothing waits for ever for a cell that failed."""
    folder = folder_of(TERMS)
    for reward, count in trained.items():
        folder.train(reward, [0.5, 0.7][:count])
    for cell in folder.cells["arp"][:failed]:
        fail(folder.store, cell, "it broke")
    assert folder.standing.look == look
    assert {cell.seed for cell in folder.standing.next} == ({100, 101, 102, 103} if look else {100, 101})


@pytest.mark.parametrize(("crashed", "answer"), [(0, "helps"), (4, "cannot tell")])
def test_trainings_that_crash_are_counted_at_the_worst_end(folder_of, crashed, answer):
    """Of a reward half of whose trainings are perfect, and half are lost."""
    folder = folder_of(Terms((8,), asked=2))
    folder.train("arp", [1.0] * (8 - crashed))
    for cell in folder.cells["arp"][8 - crashed :]:
        fail(folder.store, cell, "it broke")
    folder.train("baseline", [0.2, 0.3] * 4)
    folder.train("dense", [0.2, 0.3] * 4)
    (found,) = (it for it in folder.results.combinations if it.proposed == "arp")
    assert (found.headline.answer, found.decisive.without) == (answer, (0, crashed))


def test_who_is_decided_is_trained_no_further(folder_of):
    """The baseline goes on with the others."""
    folder = folder_of(TERMS)
    folder.train("baseline", [0.4, 0.5, 0.4, 0.5, 0.4, 0.5])
    folder.train("arp", [0.3, 0.7, 0.3, 0.7, 0.1, 0.9])
    folder.train("dense", [0.1, 1.0, 0.0, 0.9])
    standing = folder.standing
    assert "arp" not in standing.open  # all of its looks are used
    assert standing.open == ("baseline", "dense")
    assert standing.unanswered == ("arp",)
    assert standing.text == "0 of 2 decided, 1 without an answer (all looks are used), at most 2 trainings left"


def test_when_all_is_answered_nothing_is_left(folder_of):
    """The baseline alone is not trained on."""
    folder = folder_of(WIDE)
    for reward in REWARDS:
        folder.train(reward, [0.4, 0.4, 0.4, 0.4])  # alike: small from four seeds on
    standing = folder.standing
    assert standing.is_over
    assert (standing.next, standing.most_left) == ([], 0)
    assert standing.text == "2 of 2 decided"


def test_pending_cells_that_no_answer_waits_for_are_not_needed(folder_of):
    """While one reward has no answer, those of the others; the baseline's are waited for."""
    folder = folder_of(WIDE)
    folder.train("baseline", [0.4, 0.4, 0.4, 0.4])
    folder.train("dense", [0.4, 0.4, 0.4, 0.4])  # alike: over
    folder.train("arp", [0.1, 1.0, 0.0, 0.9])
    assert folder.standing.open == ("baseline", "arp")
    assert {cell.reward.label for cell in folder.standing.not_needed} == {"dense"}
    told = {(it.cell.reward.label, it.status) for it in told_manifests(folder.results) if it.status != "done"}
    assert told == {("baseline", "pending"), ("arp", "pending"), ("dense", "not needed")}


def test_an_experiment_that_trains_all_at_once_needs_every_cell(experiment):
    """Its manifests are told as they are, and it has no looks to stand at."""
    assert told_manifests(experiment) == experiment.manifests
    assert standing_of(experiment) is None


def test_seeds_of_later_looks_are_told_by_the_order_of_the_plan(folder_of):
    """Their numbers say nothing."""
    folder = folder_of(TERMS)
    for reward in REWARDS:
        folder.train(reward, [0.5, 0.7, 0.5, 0.7])
    results = folder.results
    seen = Seen.of(results.manifests, TERMS.looks)
    of_seed, complete = seen.look_of(results.combinations[0])
    assert of_seed == {100: 0, 101: 0, 102: 1, 103: 1, 104: 2, 105: 2}
    assert complete == 2
