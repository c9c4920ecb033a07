"""Cells that are compared and were made by several versions of one plugin."""

from collections.abc import Callable
from dataclasses import replace

from harness.record.cell import Cell
from harness.record.manifest import Manifest
from harness.registry.choice import Choice
from harness.results.measured import Mixture, mixtures_of

OLD, NEW, OLDER = (digits + "0" * 56 for digits in ("9340a572", "f96dd784", "11112222"))
CEM = Choice("cem", (), "cem")


def _made(cell: Cell, **sources: str) -> Manifest:
    return Manifest(cell, status="done", environment={"sources": sources} if sources else {})


def test_versions_of_one_plugin_are_counted(make_cell: Callable[..., Cell]):
    """The one that made most comes first."""
    versions = [OLD, *[NEW] * 3]
    made = [_made(make_cell(algorithm=CEM, seed=seed), algorithms=it) for seed, it in enumerate(versions)]
    assert mixtures_of(made) == (Mixture("algorithms", "cem", {NEW: 3, OLD: 1}),)


def test_newer_one_comes_first_of_as_many(make_cell: Callable[..., Cell]):
    """It is the one that is installed now, most likely."""
    made = [_made(make_cell(seed=seed), algorithms=it) for seed, it in enumerate((OLD, NEW))]
    ran = [replace(it, started=f"2026-01-0{day}T00:00:00+00:00") for it, day in zip(made, (1, 2), strict=True)]
    assert [list(mixture.cells) for mixture in mixtures_of(ran)] == [[NEW, OLD]]


def test_two_rewards_have_two_sources(make_cell: Callable[..., Cell]):
    """They are no mixture; neither are two settings of one reward."""
    cells = [make_cell(), *(make_cell(reward=Choice("arp", (("k2", k2),), f"arp:k2={k2}")) for k2 in (1.0, 2.0))]
    assert mixtures_of(map(_made, cells)) == ()
    assert mixtures_of([_made(cells[0], rewards=OLD), *(_made(cell, rewards=NEW) for cell in cells[1:])]) == ()


def test_cells_without_recorded_sources_tell_nothing(make_cell: Callable[..., Cell]):
    """Nothing is known of them."""
    assert mixtures_of([_made(make_cell()), _made(make_cell(seed=1), algorithms=NEW)]) == ()


def test_mixture_is_one_sentence():
    """With the first digits of both hashes, and what is not the same."""
    assert Mixture("algorithms", "cem", {NEW: 6, OLD: 2}).text == (
        "2 of 8 cells were made by another cem (9340a572; the others f96dd784): they are not the same algorithm"
    )


def test_every_other_version_is_named():
    """Two of them here."""
    told = Mixture("rewards", "arp", {NEW: 6, OLD: 1, OLDER: 1}).text
    assert told.startswith("2 of 8 cells were made by another arp (9340a572, 11112222; the others f96dd784)")
