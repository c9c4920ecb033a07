"""What a comparison comes to, in words: every wording there is, read as a person reads it."""

from typing import Any

import numpy as np
import pytest

from harness.eta.behaviour_change import Change, change_of
from harness.eta.curve import curve_of
from harness.eta.decompose import BB, BK, KB, KK, Decomposition, decompose
from harness.eta.verdict import basis, verdict

Sums = tuple[float, float]
SEEDS = 10
SAME: Sums = (-100.0, 100.0)


def group(sums: Sums, seeds: int = SEEDS) -> Any:
    """The curve of equal runs whose I_N and I_P are `sums`."""
    negative, positive = sums
    return curve_of([np.array([negative, positive - negative])] * seeds)


def compared(bb: Sums = SAME, bk: Sums = SAME, kb: Sums = SAME, kk: Sums = SAME, seeds: int = SEEDS) -> Decomposition:
    """The four scored groups by their I_N and I_P."""
    sums = {BB: bb, BK: bk, KB: kb, KK: kk}
    return decompose({pair: group(of, seeds) for pair, of in sums.items()})


def uncertain() -> Decomposition:
    """An eta_P of 1.1 that is all ruler, and changes from run to run: 0.3 in six of them, 2.3 in four."""
    curves = {pair: group(SAME) for pair in (BB, BK)}
    curves[KB] = curves[KK] = curve_of([np.array([-100.0, 330.0])] * 4 + [np.array([-100.0, 130.0])] * 6)
    return decompose(curves)


def change(
    baseline: list[float], proposed: list[float], name: str = "success_rate", better: str = "higher", unit: str = ""
) -> Change:
    """Of one metric, by seed."""
    return change_of(name, unit, better, list(baseline), list(proposed), [])


def about(mean: float, seeds: int = SEEDS) -> list[float]:
    """Values around a mean."""
    return list(mean + 0.02 * np.linspace(-1.0, 1.0, seeds))


def split_of(said: str) -> str:
    """What is said of eta_P."""
    return said[said.index("eta_P") :]


# The trial that all of this is for: 10 runs each, K2 = 1.5

TRIAL = {"bb": (-1000.0, 1000.0), "bk": (-1430.0, 0.5), "kb": (-60.0, 46_500.0), "kk": (-90.0, 25_600.0)}


def test_triumph_that_is_all_ruler():
    """eta_N 0.09 and eta_P 25.6 are the ruler's alone, and the robot behaves worse."""
    said = verdict(compared(**TRIAL), [change(about(0.55), about(0.12))], corrected=0.001)
    assert said == (
        "The robot behaves worse (success 12% against 55%). "
        "eta_N 0.09: all of it ruler (x 0.0629, against behaviour x 1.43). "
        "eta_P 25.6: all of it ruler (x 46.5, against behaviour x 0.551); the other path rests on an index near zero."
    )


def test_published_files_alone_tell_the_ruler_too():
    """Where only rewards and distances were recorded there is no word on behaviour, and the same on the ruler."""
    said = verdict(compared(**TRIAL))
    assert said.startswith("eta_N 0.09: all of it ruler")
    assert split_of(said).startswith("eta_P 25.6: all of it ruler")


# Behaviour


def behaviour(*changes: Change, corrected: float | None = 0.001) -> str:
    """The first sentence, of a comparison without any difference in reward."""
    said = verdict(compared(), changes, corrected)
    return said[: said.index(" eta_N")]


@pytest.mark.parametrize(("proposed", "word"), [(0.9, "better"), (0.1, "worse")])
def test_clear_success_decides(proposed: float, word: str):
    """With enough seeds, and after correction, the robot behaves so, without a proviso."""
    said = behaviour(change(about(0.5), about(proposed)))
    assert said == f"The robot behaves {word} (success {proposed:.0%} against 50%)."


def test_few_seeds_seem():
    """A difference over few seeds is told with their number."""
    said = behaviour(change(about(0.5, 3), about(0.9, 3)))
    assert said == "The robot seems to behave better (success 90% against 50%, 3 seeds only)."


@pytest.mark.parametrize("corrected", [None, 0.05, 0.3])
def test_difference_that_correction_takes_away_seems(corrected: float | None):
    """One of many comparisons may look clear by chance."""
    said = behaviour(change(about(0.5), about(0.9)), corrected=corrected)
    assert said == (
        "The robot seems to behave better (success 90% against 50%, which among all comparisons may be chance)."
    )


def test_success_decides_over_other_measures():
    """Where success differs, no other measure is told: they are in the table."""
    slower = change(about(10.0), about(20.0), "steps_to_target", "lower", "steps")
    assert behaviour(change(about(0.5), about(0.9)), slower) == behaviour(change(about(0.5), about(0.9)))


def test_no_difference_in_anything():
    """As far as the seeds tell."""
    said = behaviour(change(about(0.5), about(0.5)), change(about(2.0), about(2.0), "smoothness", "lower"))
    assert said == "The robot behaves no differently as far as 10 seeds tell (success 50% against 50%)."


def test_one_seed_tells_nothing():
    """Whatever the rates are."""
    said = behaviour(change([0.9], [0.3]))
    assert said == "Whether the robot behaves differently cannot be told from 1 seed (success 30% against 90%)."


def test_undecided_success_names_the_measures_that_differ():
    """Each with its direction, its values and its unit."""
    said = behaviour(
        change(about(0.5), about(0.5)),
        change(about(0.2), about(0.1), "final_distance", "lower", "m"),
        change(about(0.5), about(0.8), "ground_hits", "lower"),
        change(about(2.0), about(2.0), "smoothness", "lower"),
    )
    assert said == (
        "The robot succeeds as often as far as 10 seeds tell (success 50% against 50%); "
        "final distance better (0.1 against 0.2 m), ground hits worse (0.8 against 0.5)."
    )


@pytest.mark.parametrize(
    "changes",
    [
        [change(about(0.5), about(0.8), "ground_hits", "lower")],
        [change_of("success_rate", "", "higher", [None], [None], [])],
        [change_of("success_rate", "", "higher", [0.5], [None], [])],
    ],
)
def test_behaviour_that_was_not_measured(changes: list[Change]):
    """Without a success rate under both rewards there is nothing to rest on."""
    assert behaviour(*changes) == "How the robot behaves was not measured."


# How an eta splits


@pytest.mark.parametrize(
    ("ruler", "words"),
    [
        (16.0, "all of it ruler"),
        (64.0, "all of it ruler (x 64, against behaviour x 0.25)"),
        (8.0, "mostly ruler"),
        (2.0, "mostly behaviour"),
        (1.0, "all of it behaviour"),
        (0.5, "all of it behaviour (x 32, against ruler x 0.5)"),
    ],
)
def test_share_of_the_ruler(ruler: float, words: str):
    """Of an eta of 16, on a scale of factors: 4 would be half."""
    rulers = {"bk": (-100.0, 1600.0 / ruler), "kb": (-100.0, 100.0 * ruler), "kk": (-100.0, 1600.0)}
    assert split_of(verdict(compared(**rulers))) == f"eta_P 16: {words}."


def test_share_of_an_eta_below_one():
    """An eta of 1/16 splits as one of 16 does."""
    rulers = {"bk": (-12.5, 100.0), "kb": (-50.0, 100.0), "kk": (-6.25, 100.0)}
    assert verdict(compared(**rulers)).startswith("eta_N 0.0625: mostly behaviour. ")


def test_any_unit_is_all_ruler():
    """A thousandfold reward changes nothing else, and nothing is called near zero."""
    scaled = (-100_000.0, 100_000.0)
    assert verdict(compared(kb=scaled, kk=scaled)) == "eta_N 1e+03: all of it ruler. eta_P 1e+03: all of it ruler."


def test_eta_next_to_one():
    """There is nothing to split."""
    assert verdict(compared()) == "eta_N 1: next to no change. eta_P 1: next to no change."


def test_eta_next_to_one_may_hide_a_ruler():
    """Ruler and behaviour can undo one another: the ruler is told."""
    hidden = compared(bk=(-100.0, 2.5), kb=(-100.0, 4000.0), kk=(-100.0, 102.0))
    assert split_of(verdict(hidden)) == "eta_P 1.02: next to no change, though the ruler alone gives 40."


def test_ruler_near_zero_is_not_told():
    """Its number would say nothing."""
    hidden = compared(bk=(-100.0, 100.0), kb=(-100.0, 0.5), kk=(-100.0, 100.0))
    assert split_of(verdict(hidden)) == "eta_P 1: next to no change."


def test_eta_that_may_be_one_says_so():
    """Its interval holds 1: it is split all the same."""
    said = split_of(verdict(uncertain()))
    assert said == "eta_P 1.1, which these runs cannot tell from 1: all of it ruler."


def test_paths_that_disagree_are_not_split():
    """The numbers of both are told instead of a share."""
    unlike = {"bk": (-100.0, 800.0), "kb": (-100.0, 400.0), "kk": (-100.0, 800.0)}
    assert split_of(verdict(compared(**unlike))) == (
        "eta_P 8: not split, the two paths disagree: ruler 1 and behaviour 8 on the proposed runs, "
        "ruler 4 and behaviour 2 on the baseline's."
    )


def test_paths_that_agree_in_words_but_not_in_numbers():
    """Both say ruler, and not how much."""
    unlike = {"bk": (-100.0, 100.0), "kb": (-100.0, 1600.0), "kk": (-100.0, 800.0)}
    said = split_of(verdict(compared(**unlike)))
    assert said == "eta_P 8: all of it ruler; the two paths disagree on how much."


def test_paths_on_either_side_of_a_word():
    """Rulers that agree but for a little may fall on both sides of one half: then it is about that."""
    near = {"bk": (-100.0, 410.0), "kb": (-100.0, 420.0), "kk": (-100.0, 1600.0)}
    said = split_of(verdict(compared(**near)))
    assert said == "eta_P 16: about half ruler, half behaviour."


def test_no_path_that_can_be_used():
    """Both rest on an index near zero."""
    weak = {"bk": (-100.0, 0.5), "kb": (-100.0, 0.3), "kk": (-100.0, 40.0)}
    said = split_of(verdict(compared(**weak)))
    assert said == "eta_P 0.4: not split, its parts rest on indices near zero or of unlike sign."


def test_eta_that_says_little():
    """The reason, without a number."""
    said = split_of(verdict(compared(kb=(-100.0, 4000.0), kk=(-100.0, 1.0))))
    assert said == (
        "eta_P says little: I_P of the proposed reward is near zero beside that of the baseline runs under the "
        "proposed reward."
    )


def test_eta_that_is_not_defined():
    """The reason behind n/a."""
    never = compared(bb=(-100.0, 0.0), seeds=3)
    assert split_of(verdict(never)) == (
        "eta_P n/a: I_P of the baseline is 0: its mean accumulated reward is never positive."
    )


def test_eta_that_was_not_scored_again():
    """What is missing."""
    alone = decompose({BB: group(SAME), KK: group((-100.0, 200.0))}, missing="base.csv has no distances to score again")
    assert split_of(verdict(alone)) == "eta_P 2: not split, base.csv has no distances to score again."


@pytest.mark.parametrize("seeds", [1, 2, 4])
def test_verdict_is_one_line_of_whole_sentences(seeds: int):
    """Whatever the notes are."""
    said = verdict(compared(**TRIAL, seeds=seeds), [change(about(0.5, seeds), about(0.4, seeds))])
    assert "\n" not in said
    assert said.endswith(".")
    assert ".." not in said
    assert "  " not in said


# What it rests on


def test_basis_counts_seeds_and_episodes():
    """And says that the traces were scored again."""
    said = basis(compared(), [change(about(0.5), about(0.6))], 20)
    assert said == "Rests on 10 paired seeds, 20 evaluation episodes each, and the training traces re-scored."


def test_basis_of_one_seed():
    """One seed, one episode."""
    said = basis(compared(seeds=1), [change([0.5], [0.6])], 1)
    assert said == "Rests on 1 paired seed, 1 evaluation episode, and the training traces re-scored."


def test_basis_does_not_claim_what_was_not_scored():
    """Where nothing could be scored again the traces are as they were recorded."""
    alone = decompose({BB: group(SAME), KK: group(SAME)}, missing="no reward 'lost'")
    assert basis(alone, [change(about(0.5), about(0.6))], 20) == (
        "Rests on 10 paired seeds, 20 evaluation episodes each, and the training traces as recorded."
    )


def test_basis_says_how_many_seeds_would_decide():
    """Where an eta cannot be told from 1."""
    found = uncertain()
    assert found.positive.seeds_needed > SEEDS
    said = basis(found, [change(about(0.5), about(0.6))], 20)
    assert said.endswith(f" About {found.positive.seeds_needed} seeds would decide whether eta_P differs from 1.")
    assert "eta_N" not in said
