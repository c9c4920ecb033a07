"""Computes numbers and words from numbers: the note's indices, their ratios, and how far these can be trusted."""

from typing import TYPE_CHECKING

from harness.face import face_of

if TYPE_CHECKING:
    from harness.eta.auc import AGAINST as AGAINST, CANNOT_TELL as CANNOT_TELL, RANKS as RANKS, auc_of as auc_of
    from harness.eta.behaviour_change import (
        Change as Change,
        Quantity as Quantity,
        change_of as change_of,
        together as together,
    )
    from harness.eta.curve import GroupCurve as GroupCurve, curve_of as curve_of
    from harness.eta.decomposition import decompose as decompose
    from harness.eta.equal import equal_sentences as equal_sentences, equal_trainings as equal_trainings
    from harness.eta.headline import (
        UNMEASURED as UNMEASURED,
        Answer as Answer,
        number_sentence as number_sentence,
        return_sentence as return_sentence,
        split_returns as split_returns,
    )
    from harness.eta.index import (
        Estimate as Estimate,
        Index as Index,
        mean_over_seeds as mean_over_seeds,
    )
    from harness.eta.interval import SHARE as SHARE, UNBOUNDED as UNBOUNDED
    from harness.eta.judgement import Verdict as Verdict, lead_of as lead_of
    from harness.eta.laws import (
        Curve as Curve,
        Curves as Curves,
        Span as Span,
        counted as counted,
        latest_shared as latest_shared,
        require_share as require_share,
        shortfall_beside as shortfall_beside,
        within as within,
    )
    from harness.eta.manner import TRAINING as TRAINING
    from harness.eta.ranking import (
        agreement_of as agreement_of,
        order_rewards as order_rewards,
        transplant as transplant,
    )
    from harness.eta.rescaling import Rescaling as Rescaling, line_of as line_of, rescaling_of as rescaling_of
    from harness.eta.splits import (
        BB as BB,
        BK as BK,
        KB as KB,
        KK as KK,
        Names as Names,
        Split as Split,
    )
    from harness.eta.swaps import Swaps as Swaps, corrected_p as corrected_p, p_of as p_of, swaps_of as swaps_of
    from harness.eta.verdict.halving import (
        Rung as Rung,
        fewest as fewest,
        halve as halve,
        schedule_of as schedule_of,
        usual as usual,
    )
    from harness.eta.verdict.looks import LookRuling as LookRuling, Looks as Looks, rule_in_looks as rule_in_looks
    from harness.eta.verdict.question import Question as Question
    from harness.eta.verdict.ruling import Ruling as Ruling, rule as rule
else:
    __all__, __getattr__ = face_of(__name__)
