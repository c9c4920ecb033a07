"""Experiments that are trained in looks: what they agree on, and what they refuse."""

from dataclasses import replace

import pytest

from harness.errors import UsageError
from harness.eta.verdict.looks import ONE_PLACE, SEVERAL_PLACES
from harness.experiment.experiment import prepare
from harness.experiment.looks import own_seed
from harness.experiment.plan import check_experiment, expand
from harness.experiment.run_options import RunOptions
from harness.files.bounded import read_sealed, seal
from harness.record import Store, Terms
from harness.registry import Choice
from tests.left import files_of
from tests.refusals import refused


def planned(registry, **fields):
    """A plan that trains until decided, unless it says otherwise."""
    given = {"sim": "ideal", "algo": "wander", "reward": "dense", "steps": 12, "evaluation_episodes": 2}
    return expand(check_experiment({**given, "until": "decided", **fields}), registry)


FOUR = [f"fd100-reach:horizon={steps}" for steps in (5, 6, 7, 8)]
TWO = {"reward": ["dense", "arp"]}


@pytest.mark.parametrize(
    ("fields", "terms"),
    [
        ({}, Terms(ONE_PLACE, 1, 0.10, averaged=5)),
        ({"task": FOUR}, Terms(SEVERAL_PLACES, 1, 0.10, averaged=5)),
        (TWO, Terms(ONE_PLACE, 2, 0.10, averaged=5)),
        ({**TWO, "until": "best"}, Terms(asked=2, averaged=5, budget=28)),
        ({**TWO, "until": "best", "trainings": 14}, Terms(asked=2, averaged=5, budget=14)),
        ({**TWO, "until": "best", "minutes": 90.0}, Terms(asked=2, averaged=5, budget=112, seconds=5400.0)),
        ({"until": "", "seeds": 2}, Terms(averaged=5)),
    ],
    ids=[
        "one place",
        "seeds of several add up",
        "two questions share the level",
        "usual",
        "trainings",
        "time",
        "no looks",
    ],
)
def test_terms_of_an_experiment(toys, fields, terms):
    """Its looks, how many rewards are asked about, a margin of ten points; what choosing may spend at most."""
    assert planned(toys, **fields).terms == terms


def test_all_seeds_of_the_last_look_are_planned(toys):
    """They are foreseen before the first one is trained."""
    assert len(planned(toys, looks=[2, 3]).cells) == 2 * 3


def test_places_have_seeds_of_their_own(make_cell):
    """Equal seeds would share luck; rewards in one place share theirs."""
    one = own_seed(make_cell(seed=3))
    reward, place = replace(make_cell(seed=3), reward=Choice("dense", (), "dense")), make_cell(seed=3, robot="other")
    assert own_seed(reward).seed == one.seed
    assert own_seed(place).seed != one.seed


def test_a_seed_of_its_own_is_the_same_on_every_machine(make_cell):
    """It follows from the place and the seed."""
    assert own_seed(make_cell(seed=3)).seed == 701951709


@pytest.mark.parametrize(
    ("fields", "told"),
    [
        ({"looks": [8, 6]}, "looks=8,6: the numbers of seeds have to increase"),
        ({"looks": [1, 6]}, "the first look needs at least 2 seeds"),
        ({"looks": []}, "the numbers of seeds have to increase"),
        ({"margin": 0.0}, "margin"),
        ({"margin": 1.0}, "margin"),
        ({"seeds": 5}, "finds the number of seeds itself"),
        ({"until": "", "looks": [4, 8]}, "looks go with until"),
        ({**TWO, "until": "best", "looks": [4, 8]}, "harness choose has a budget instead"),
        ({"trainings": 40}, "trainings: give one of trainings and minutes, with until best"),
        ({"until": "best", "trainings": 40, "minutes": 9.0}, "trainings and minutes: give one of"),
        ({"until": "best"}, "one candidate leaves nothing to choose"),
        ({**TWO, "until": "best", "task": FOUR, "trainings": 23}, "24 trainings are the fewest"),
        ({"until": "tomorrow"}, "until"),
        ({"reward": []}, "there is no reward to compare with the baseline"),
        ({"reward": ["baseline", "dense"]}, "the null control"),
    ],
)
def test_what_cannot_be_asked_says_why(toys, fields, told):
    """Before anything is written."""
    with refused(told):
        planned(toys, **fields)


@pytest.fixture
def begun(toys, tmp_path):
    """Prepare an experiment in a folder; gives what it is refused for."""

    def prepare_again(**fields):
        given = {"sim": "ideal", "algo": "wander", "reward": "dense", "steps": 12, "evaluation_episodes": 2}
        experiment = check_experiment({**given, **fields})
        try:
            prepare(experiment, RunOptions(out=tmp_path / "here", executor="here")).run()
        except UsageError as error:
            return str(error)
        return ""

    return prepare_again


@pytest.mark.parametrize(
    "changed",
    [
        {"until": "decided", "looks": [2, 4, 6]},
        {"until": "decided", "looks": [2, 4], "margin": 0.05},
        {"until": "decided", "looks": [2, 4], "reward": ["dense", "arp"]},
        {"until": "decided", "looks": [2, 4], "task": "fd100-reach:horizon=5"},
        {"until": "best", "reward": ["dense", "arp"]},
        {"seeds": 3},
    ],
)
def test_what_was_agreed_on_stays(begun, tmp_path, changed):
    """Looks, margin, rewards and places: who changes them begins another experiment. Nothing is written."""
    assert begun(until="decided", looks=[2, 4]) == ""
    before = files_of(tmp_path / "here")
    told = begun(**changed)
    assert "What it asks is settled before its first training" in told
    assert "--out NEW" in told
    assert files_of(tmp_path / "here") == before


def test_a_folder_that_was_begun_without_looks_gets_none(begun):
    """Its seeds were not foreseen."""
    assert begun(seeds=1) == ""
    assert "it was begun without looks, so its seeds were not foreseen" in begun(until="decided", looks=[2, 4])


def test_the_same_experiment_goes_on(begun, tmp_path):
    """And trains nothing twice."""
    assert begun(until="decided", looks=[2, 4]) == ""
    before = files_of(tmp_path / "here" / "cells")
    assert begun(until="decided", looks=[2, 4]) == ""
    assert files_of(tmp_path / "here" / "cells") == before


def test_seeds_that_no_plan_foresaw_are_written_down(begun, tmp_path):
    """With how many were done before."""
    assert begun(seeds=1) == ""
    assert begun(seeds=3) == ""
    assert Store.open(tmp_path / "here").read_plan().terms.grown == (1,)


def test_rewards_that_come_later_are_written_down(begun, tmp_path):
    """They are no further look: they have no results that somebody could have looked at."""
    assert begun(seeds=1) == ""
    assert begun(seeds=1, reward=["dense", "arp"]) == ""
    terms = Store.open(tmp_path / "here").read_plan().terms
    assert (terms.grown, terms.joined) == ((), ("arp",))


def test_a_race_of_an_earlier_version_does_not_go_on(begun, tmp_path):
    """Rewards are chosen in another way now. It is compared as any other experiment, at its second look."""
    assert begun(until="decided", looks=[2, 4]) == ""
    content = read_sealed(tmp_path / "here" / "plan.json", "plan", 2, 2, 2**20)
    content["terms"]["race"] = True
    (tmp_path / "here" / "plan.json").write_bytes(seal(content))
    terms = Store.open(tmp_path / "here").read_plan().terms
    assert (terms.looks, terms.grown) == ((), (2,))
    told = begun(until="best", reward=["dense", "arp"])
    assert "holds a race that version 0.3 or an earlier one began" in told
    assert "--out NEW" in told
