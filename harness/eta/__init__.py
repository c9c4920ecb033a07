"""Computes numbers and words from numbers: the note's indices, their ratios, and how far these can be trusted."""

from typing import TYPE_CHECKING, Any

from harness.face import look_up

if TYPE_CHECKING:
    from harness.eta.auc import AGAINST, CANNOT_TELL, RANKS, auc_of
    from harness.eta.behaviour_change import TRAINING, Change, Quantity, change_of
    from harness.eta.curve import GroupCurve, Kind, curve_of
    from harness.eta.decomposition import decompose
    from harness.eta.equal import equal_sentences, equal_trainings
    from harness.eta.headline import UNMEASURED, Answer, Headline
    from harness.eta.index import Index, Ratio
    from harness.eta.interval import SHARE, UNBOUNDED, Bounds
    from harness.eta.judgement import judge
    from harness.eta.lead import lead_of
    from harness.eta.number import number_sentence, return_sentence
    from harness.eta.ranking import Agreement, agreement_of, order_rewards, transplant
    from harness.eta.rescaling import Rescaling, line_of, rescaling_of
    from harness.eta.return_split import split_returns
    from harness.eta.scored_sums import BB, BK, KB, KK, Pair
    from harness.eta.seed_mean import SeedMean, mean_over_seeds
    from harness.eta.splits import Decomposition, Names, Split, no_splits
    from harness.eta.swaps import Swaps, corrected_p, p_of, swaps_of
    from harness.eta.verdict.looks import LookRuling, Looks, rule_in_looks
    from harness.eta.verdict.question import Question
    from harness.eta.verdict.race import RACE, Race, race
    from harness.eta.verdict.ruling import Ruling, rule

__all__ = [
    "AGAINST",
    "BB",
    "BK",
    "CANNOT_TELL",
    "KB",
    "KK",
    "RACE",
    "RANKS",
    "SHARE",
    "TRAINING",
    "UNBOUNDED",
    "UNMEASURED",
    "Agreement",
    "Answer",
    "Bounds",
    "Change",
    "Decomposition",
    "GroupCurve",
    "Headline",
    "Index",
    "Kind",
    "LookRuling",
    "Looks",
    "Names",
    "Pair",
    "Quantity",
    "Question",
    "Race",
    "Ratio",
    "Rescaling",
    "Ruling",
    "SeedMean",
    "Split",
    "Swaps",
    "agreement_of",
    "auc_of",
    "change_of",
    "corrected_p",
    "curve_of",
    "decompose",
    "equal_sentences",
    "equal_trainings",
    "judge",
    "lead_of",
    "line_of",
    "mean_over_seeds",
    "no_splits",
    "number_sentence",
    "order_rewards",
    "p_of",
    "race",
    "rescaling_of",
    "return_sentence",
    "rule",
    "rule_in_looks",
    "split_returns",
    "swaps_of",
    "transplant",
]

_HOMES = {
    "auc": "AGAINST CANNOT_TELL RANKS auc_of",
    "behaviour_change": "TRAINING Change Quantity change_of",
    "curve": "GroupCurve Kind curve_of",
    "decomposition": "decompose",
    "equal": "equal_sentences equal_trainings",
    "headline": "UNMEASURED Answer Headline",
    "index": "Index Ratio",
    "interval": "SHARE UNBOUNDED Bounds",
    "judgement": "judge",
    "lead": "lead_of",
    "number": "number_sentence return_sentence",
    "ranking": "Agreement agreement_of order_rewards transplant",
    "rescaling": "Rescaling line_of rescaling_of",
    "return_split": "split_returns",
    "scored_sums": "BB BK KB KK Pair",
    "seed_mean": "SeedMean mean_over_seeds",
    "splits": "Decomposition Names Split no_splits",
    "swaps": "Swaps corrected_p p_of swaps_of",
    "verdict.looks": "LookRuling Looks rule_in_looks",
    "verdict.question": "Question",
    "verdict.race": "RACE Race race",
    "verdict.ruling": "Ruling rule",
}


def __getattr__(name: str) -> Any:
    return look_up(__name__, _HOMES, name)
