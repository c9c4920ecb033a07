"""Cells that are compared and were made by several versions of one plugin."""

import pytest

from harness.record import Manifest
from harness.registry import Choice
from harness.results.compare import mixtures_of
from harness.results.metrics import Mixture

OLD, NEW, OLDER = (digits + "0" * 56 for digits in ("9340a572", "f96dd784", "11112222"))
ARPS = tuple(Choice("arp", (("k2", k2),), f"arp:k2={k2}") for k2 in (1.0, 2.0))


def _found(make_cell, *sources, rewards=None):
    """Of a training a day; the reward of each where it is another."""
    fields = [{"reward": it} if it else {} for it in rewards or [None] * len(sources)]
    return mixtures_of(
        Manifest(
            make_cell(algorithm=Choice("cem", (), "cem"), seed=seed, **of),
            status="done",
            started=f"2026-01-0{seed + 1}T00:00:00+00:00",
            environment={"sources": source} if source else {},
        )
        for seed, (source, of) in enumerate(zip(sources, fields, strict=True))
    )


@pytest.mark.parametrize(
    ("versions", "told"), [((OLD, NEW, NEW, NEW), {NEW: 3, OLD: 1}), ((OLD, NEW), {NEW: 1, OLD: 1})]
)
def test_versions_of_one_plugin_are_counted(make_cell, versions, told):
    """The one that made most comes first; of as many the newer one, which is installed now, most likely."""
    (found,) = _found(make_cell, *({"algorithms": it} for it in versions))
    assert (found, [*found.cells]) == (Mixture("algorithms", "cem", told), [*told])


def test_two_rewards_have_two_sources(make_cell):
    """They are no mixture; neither are two settings of one reward, nor cells whose sources were not recorded."""
    rewards = (None, *ARPS)
    assert _found(make_cell, None, None, None, rewards=rewards) == ()
    assert _found(make_cell, {"rewards": OLD}, {"rewards": NEW}, {"rewards": NEW}, rewards=rewards) == ()
    assert _found(make_cell, None, {"algorithms": NEW}) == ()


@pytest.mark.parametrize(
    ("part", "name", "told"), [("versions", "numpy", "numpy"), ("machine", "kernel", "kernel of OpenBLAS")]
)
def test_libraries_and_kernels_are_compared(make_cell, part, name, told):
    """Those that are recorded: version 0.3 told no kernel, and numpy may have none of OpenBLAS."""
    versions = ("SkylakeX", "SkylakeX", "Haswell and then SkylakeX", "")
    told_of = [{part: {name: it}} for it in versions]
    (found,) = mixtures_of(Manifest(make_cell(), status="done", environment=it) for it in [*told_of, {}])
    other = f"1 of 3 cells was made by another {told} (Haswell and then SkylakeX; the others SkylakeX)"
    assert found.text == f"{other}: they are not the same {told}"


def test_mixture_is_one_sentence():
    """With the first digits of every other version's hash, and what is not the same."""
    assert Mixture("algorithms", "cem", {NEW: 6, OLD: 2}).text == (
        "2 of 8 cells were made by another cem (9340a572; the others f96dd784): they are not the same algorithm"
    )
    assert " another arp (9340a572, 11112222; " in Mixture("rewards", "arp", {NEW: 6, OLD: 1, OLDER: 1}).text
