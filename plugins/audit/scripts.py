"""A reward on the scripted movements of an arm: everything is asked of it. Trains nothing."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harness.authoring.commands import (
    CREEP,
    FINISH,
    HOLD,
    HOVER,
    Episodes,
    Score,
    on_finishing,
    on_terms,
    under_noise,
)
from harness.log import REWARD, SUCCESS, Log, LogFacts, in_memory
from harness.payoff import Rollout, discounted_sum, finishing_of, score_rollout
from harness.reward import Reward
from harness.text import number

from .audit import Audit, OfScripts
from .probe import needed_beside_distances
from .properties import properties_of, workspace_ratios
from .recorded.earned import earned_in_episodes
from .recorded.pair import pairs_in
from .recorded.pair_grid import SCALE
from .search.disturb import NOISES
from .search.finding import FRAGILE, ROBUST
from .transitions.rollout_forms import COMPARED, forms_of_rollouts


def verdict_of(found: OfScripts) -> list[str]:
    """One line on finishing, and one for whatever else needs a warning."""
    of = found.finishing
    payoffs = {payoff.policy: payoff for payoff in of.payoffs}
    lines = [on_finishing(of)]
    if found.disturbed is not None and (of.undiscounted or of.discounted):
        noisy = under_noise(of, found.disturbed)
        word, rate = ROBUST if noisy.is_robust else FRAGILE, "" if of.undiscounted else f", discounted by {of.gamma:g}"
        lines.append(
            f"{word}: with action noise {NOISES[-1]:g} {noisy.policy} earns {number(noisy.earns)} per episode{rate}, "
            f"finish {number(noisy.finish_earns)}."
        )
    if of.holding_pays:
        hold, gamma = payoffs[HOLD], of.gamma
        earned = f"{number(hold.shaped)} of shaped reward per episode, {number(hold.shaped_discounted)}"
        taken_back = any(it.name == "potential-based" and it.gamma == gamma for it in found.properties)
        back = " It is shaping by a potential, and the discount takes it back." if taken_back else ""
        lines.append(f"Holding still pays: {earned} discounted by {gamma:g}.{back}")
    if payoffs[FINISH].success < 1.0:
        lines.append(f"finish reached the target in only {payoffs[FINISH].success:.0%} of the episodes.")
    lines += [
        f"{name} could not stay outside epsilon: {payoffs[name].success:.0%} of its episodes ended at the target."
        for name in (HOVER, CREEP)
        if payoffs[name].success > 0.0
    ]
    return [*lines, *on_terms(of)]


STEPS = "steps"
TRIED = 64
"""So many episodes of each script are enough to try properties on."""


def audit_reward(
    reward: Reward,
    against: Reward,
    rollouts: Sequence[Rollout],
    gamma: float,
    names: tuple[str, str] = ("reward", "against"),
    setting: str = "",
    disturbed: Sequence[Rollout] = (),
) -> Audit:
    """What `reward` pays for in the rollouts of the scripted policies.

    Args:
        reward: The reward.
        against: The one that it is compared with.
        rollouts: One of each script.
        gamma: The learner's discount per step, in (0, 1].
        names: What the two are called.
        setting: Where the scripted policies were recorded.
        disturbed: The same scripts with noise on their actions; none if that was not tried.

    Raises:
        SimulationDiverged: One of the two pays a number that is not finite.
        UsageError: One of the two reads what no step of an arm has, or its terms are none.
    """
    name, other = names
    scores, others = ([score_rollout(it, rollout) for rollout in rollouts] for it in (reward, against))
    needed = needed_beside_distances(reward, scores)
    forms = {who: forms_of_rollouts(it, rollouts, gamma) for who, it in ((other, against), (name, reward))}
    finishing = finishing_of(scores, gamma)
    asked = OfScripts(
        finishing,
        properties_of(reward, [rollout.distances[:, :TRIED] for rollout in rollouts], gamma, needed),
        {rollout.script: None for rollout in rollouts} if needed else workspace_ratios(reward, rollouts),
        needed,
        min(COMPARED, finishing.steps),
        finishing_of([score_rollout(reward, rollout) for rollout in disturbed], gamma) if disturbed else None,
    )
    both = [dict(zip((other, name), of, strict=True)) for of in zip(others, scores, strict=True)]
    pairs, _ = pairs_in([("scripts", _log(both))], (other, name), [forms])
    return Audit(
        title=name,
        setting=(setting,) if setting else (),
        facts={},
        rewards=tuple(both[0]),
        pairs=pairs,
        earned=tuple(
            earned_in_episodes(score.rollout.script, [_episodes(of)], list(of), (SUCCESS, STEPS))
            for score, of in zip(scores, both, strict=True)
        ),
        success=SUCCESS,
        verdict=tuple(verdict_of(asked)),
        scripts=asked,
        measured=(f"{SCALE} {asked.compared:,} recorded steps were compared.",),
    )


def _log(both: Sequence[Mapping[str, Score]]) -> Log:
    """What both rewards paid in all rollouts, the events left out, which the task pays under either."""
    rollouts = [next(iter(scores.values())).rollout for scores in both]

    def flat(values: Iterable[NDArray[Any]]) -> NDArray[Any]:
        return np.concatenate([of[rollout.running] for of, rollout in zip(values, rollouts, strict=True)])

    after = [np.vstack([rollout.running[1:], np.zeros_like(rollout.running[:1])]) for rollout in rollouts]
    ends = [rollout.running & ~now for rollout, now in zip(rollouts, after, strict=True)]
    columns = {
        "env": flat(np.broadcast_to(np.arange(len(rollout.reached)), rollout.running.shape) for rollout in rollouts),
        "episode": flat(np.full(rollout.running.shape, number) for number, rollout in enumerate(rollouts)),
        "terminated": flat(end & rollout.reached for end, rollout in zip(ends, rollouts, strict=True)),
        "truncated": flat(ends),
        **{f"{REWARD}{name}": flat(scores[name].values for scores in both) for name in both[0]},
    }
    return in_memory(LogFacts(path=Path(), format="scripts"), columns)


def _episodes(scores: Mapping[str, Score]) -> Episodes:
    """The episodes of one rollout, the events among what they were paid."""
    rollout = next(iter(scores.values())).rollout
    returns = {name: discounted_sum(score.paid, 1.0) for name, score in scores.items()}
    measures = {SUCCESS: np.asarray(rollout.reached, np.float64), STEPS: rollout.steps}
    return Episodes(np.cumsum(rollout.steps).astype(np.int64) - 1, returns, measures, {})
