"""The process of a trial may be ended by a reward, or kept busy: that one is named, and all others are tried."""

import pytest

from harness.experiment.trials import tried_plan as module
from harness.experiment.trials.tried import Fault, Tried, fault_of
from harness.experiment.trials.tried_plan import TryTask, try_tasks
from tests.experiment.trials.conftest import planned


def works(given):
    """The trial of a plan with these files."""
    plan, _ = planned(given)
    return [TryTask(plan.cells[0], (), given)]


def test_what_ends_the_process_is_named_and_the_rest_is_tried(lay):
    """One process is lost, and the next one finds what only raises."""
    (tried,) = try_tasks(works(lay(ends="__import__('os')._exit(3)", far="return 1.0", raises="return 1 / 0")))
    lost, raises = tried.faults
    assert lost == Fault(
        "reward",
        "ends",
        "ends the process: its process ended with exit status 3 before the trial did.",
        is_lost=True,
    )
    assert (raises.name, raises.is_lost) == ("raises", False)


@pytest.mark.slow  # as long as a call may take
def test_what_never_returns_is_named(lay):
    """Though it holds the interpreter."""
    (tried,) = try_tasks(works(lay(stays="return sum(iter(int, 1))")))
    (fault,) = tried.faults
    assert (fault.name, fault.reason) == ("stays", f"has not returned after {module.CALL_SECONDS:g} s.")


def test_where_every_process_is_lost_no_other_is_started(lay, monkeypatch):
    """What was found until then is told."""
    monkeypatch.setattr(module, "MOST_LOST", 0)
    (tried,) = try_tasks(works(lay(ends="__import__('os')._exit(3)")))
    assert [fault.name for fault in tried.faults] == ["ends"]


def test_orders_and_answers_come_back_from_json(lay):
    """As they were."""
    (work,) = works(lay(far="return 1.0"))
    assert TryTask.from_json(work.to_json()) == work
    tried = Tried((fault_of("behaviour_height", "is odd."),), ("a note",))
    assert Tried.from_json(tried.to_json()) == tried
    assert tried.faults[0].column == "behaviour_height"
    assert tried.faults[0].sentence == "measure 'height' is odd."
