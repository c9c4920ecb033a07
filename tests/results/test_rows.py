"""The comparisons as a table."""

from dataclasses import replace

from harness.eta.headline import Answer
from harness.eta.verdict.ruling import Ruling
from harness.results.comparison import Behaviour, Comparison, Judged, Number
from harness.results.table import SCHEMA, comparison_rows
from tests.results.test_comparison import CHANGES, CURVES, GROUP, decompose

COMPARED = Comparison(
    GROUP, "baseline", "arp", tuple(range(6)), measured=Behaviour(CHANGES, episodes={"deterministic": 20}),
    number=Number(decompose(CURVES)), answer=Judged(Ruling(0.01, 0.02), claims=5), curves=CURVES,
)  # fmt: skip


def row_of(comparison: Comparison) -> dict[str, object]:
    """The one row of its table."""
    (row,) = comparison_rows([comparison]).to_pylist()
    return row


def test_row_names_place_rewards_and_answer():
    """As the comparison does."""
    row = row_of(COMPARED)
    assert (row["simulator"], row["task"], row["baseline"], row["proposed"]) == (
        "ideal",
        "fd100-reach",
        "baseline",
        "arp",
    )
    assert (row["seeds"], row["steps"]) == (6, 12)
    assert row["answer"] in {it.value for it in Answer}


def test_row_has_the_test_and_the_numbers():
    """As exact as they are known."""
    row, change = row_of(COMPARED), COMPARED.decisive
    assert (row["p"], row["p_corrected"]) == (0.01, 0.02)
    assert change is not None
    assert (row["measure"], row["difference"]) == (change.name, change.difference)
    assert (row["eta_P"], row["ruler"]) == (COMPARED.number.eta_p.value, COMPARED.number.splits["eta_P"].ruler.value)


def test_what_is_not_known_is_null():
    """An environment has no robot; without a ruling there is no p."""
    row = row_of(replace(COMPARED, answer=Judged(), group=GROUP._replace(robot="", simulator=None)))
    assert row["p"] is None
    assert row["simulator"] is None


def test_empty_table_has_all_columns():
    """So that a program that reads it need not ask."""
    assert comparison_rows([]).schema == SCHEMA


def test_row_counts_the_trainings_of_each_reward():
    """They need not be as many, nor have seeds in common."""
    row = row_of(replace(COMPARED, trained=((0, 1, 2), (1, 2))))
    assert (row["baseline_trainings"], row["proposed_trainings"]) == (3, 2)
