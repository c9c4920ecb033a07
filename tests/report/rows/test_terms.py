"""What each term paid, as text."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from harness.eta import mean_over_seeds
from harness.report import terms_grid
from harness.report.rows.returns import never_texts
from harness.results import Group
from harness.results.trainings import TermPaid, TermsPaid


def _mean(*values):
    return mean_over_seeds(values)


@pytest.fixture(name="alone")
def _alone(make_cell):
    reach = TermPaid("reach", _mean(-9.0, -8.0, -7.0), _mean(-2.0, -2.0, -2.0), _mean(-1.0, -2.0, -3.0), random=-20.0)
    dock = TermPaid("dock", _mean(0.0), _mean(0.0), _mean(0.0), never=True)
    return TermsPaid(Group.of(make_cell()), "gentle", "", 3, 30_720, (reach, dock))


@pytest.fixture(name="compared")
def _compared(alone):
    reach, dock = alone.terms
    beside = replace(reach, others=_mean(-4.0), behaviour=_mean(2.0), ruler=_mean(0.5))
    return replace(alone, baseline="own", terms=(beside, replace(dock, others=_mean(0.0), behaviour=_mean(0.0))))


def test_only_columns_that_are_known_are_shown(alone, compared):
    """A reward alone stands beside nothing."""
    assert terms_grid(alone).headings == ("an episode", "start", "end", "evaluation", "random")
    assert terms_grid(compared).headings[4:] == ("with own", "random", "behaviour", "ruler")


def test_an_interval_stands_below_its_mean(alone):
    """None without a width, which would be taken for certainty."""
    first, interval, *others = terms_grid(alone).rows
    assert first == ("reach", "-8.00", "-2.00", "-2.00", "-20.0")
    assert (interval[0], interval[2], interval[4]) == ("  95% interval", "", "")
    assert interval[1].startswith("[-10.5")
    assert [row[0] for row in others] == ["dock"]


def test_a_term_that_never_paid_is_said(alone):
    """With all steps of all trainings, also at a glance."""
    assert "`dock` never paid in 30,720 steps." in terms_grid(alone).notes
    assert never_texts(SimpleNamespace(terms=[alone])) == ["gentle: `dock` never paid in 30,720 steps."]


def test_a_term_that_pays_in_the_evaluations_alone_is_said_so(alone):
    """No training had it, but the table beside the sentence has a number."""
    reach, dock = alone.terms
    found = replace(alone, terms=(reach, replace(dock, evaluation=_mean(0.0, 1.0))))
    assert "`dock` never paid in 30,720 steps of training, only in the evaluations." in terms_grid(found).notes


def test_a_term_of_weight_0_has_a_reason(alone):
    """It cannot pay."""
    found = replace(alone, reward="gentle:dock=0")
    assert "`dock` never paid in 30,720 steps: its weight is 0." in terms_grid(found).notes


def test_no_share_raises_an_alarm(alone):
    """A term that pays nearly all is what its author asked for."""
    told = " ".join(terms_grid(alone).notes)
    assert not [word for word in ("dominat", "share", "better", "worse", "%") if word in told]


def test_what_changed_most_is_told(alone, compared):
    """Over the training, or beside the baseline's trainings; nothing of a single term."""
    told = "`reach` changed most: -8.00 an episode at the start of the trainings, -2.00 at their end."
    assert told in terms_grid(alone).notes
    differs = "`reach` differs most: it pays -2.00 an episode of the evaluations, and -4.00 with own."
    assert differs in terms_grid(compared).notes
    assert not any("most" in note for note in terms_grid(replace(alone, terms=alone.terms[:1])).notes)


def test_the_path_is_told(compared):
    """On which behaviour adds up."""
    notes = " ".join(terms_grid(compared).notes)
    assert "one of the two paths: behaviour under gentle, the ruler on the episodes of own's trainings." in notes
