"""A reward on the scripted movements of an arm: everything is asked of it. Trains nothing."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float, Ints
from harness.authoring.commands import (
    CREEP,
    DISTANCE,
    FINISH,
    HOLD,
    HOVER,
    Episodes,
    Score,
    on_finishing,
    on_terms,
    paid_along,
    rows_of,
    step_between,
    under_noise,
)
from harness.log import REWARD, SUCCESS, Log, LogFacts, in_memory
from harness.payoff import Rollout, discounted_sum, finishing_of, score_rollout
from harness.reward import Carry, Reward, Steps, pay
from harness.text import number

from .audit import Audit, OfScripts
from .distance import DARD, EPIC, Form, centred_unit
from .probe import needed_beside_distances
from .properties import properties_of, workspace_ratios
from .recorded.earned import earned_in_episodes
from .recorded.pair import pairs_in
from .recorded.pair_grid import SCALE
from .search.disturb import NOISES
from .search.finding import FRAGILE, ROBUST
from .transitions.rollout_forms import COMPARED, forms_of_rollouts

SAMPLES = 64
"""So many distances stand for EPIC's D."""

GROUPS = 32
"""Recorded steps that began at about the same distance are a group; so many groups of about the same size."""

CHANGES = 16
"""So many changes of the distance stand for those of a group."""


Expectation: TypeAlias = Callable[[Reward, Carry, Steps], tuple[Float, Float]]
"""What steps other than the one taken would pay, on average; (n,) each: of R, of what is remembered in s, and of the
step from s to s' that was taken, E[R(s, D')] and E[R(S', D'')], which is 0 where the form has no such term."""


@dataclass(frozen=True, eq=False)
class Anywhere:
    """EPIC's: a step may lead to any recorded distance.

    Attributes:
        distances: The distances that stand for all, (SAMPLES,), [m].
    """

    distances: Float

    def __call__(self, reward: Reward, carry: Carry, step: Steps) -> tuple[Float, Float]:
        """The second is 0: EPIC's last term is a constant."""
        count, size = len(self.distances), len(step.distance)
        led = _leading_to(rows_of(step, _each(size, count)), np.tile(self.distances, size))
        return _mean(pay(reward, _repeated(carry, count), led)[1].total, count), np.zeros(size)


@dataclass(frozen=True, eq=False)
class Nearby:
    """DARD's: a step changes the distance as a recorded step from nearby did.

    DARD averages over actions A, and both steps of a pair, from s and from s', take the same one. Here A says which of
    a group's changes it is, counted from the largest approach.

    Attributes:
        edges: Distance at which each group begins, but for the first, (groups - 1,), [m].
        changes: Quantiles of the changes of each group, (groups, CHANGES), [m].
        lowest: Smallest distance that a recorded step led to, [m]; no step leads below it.
    """

    edges: Float
    changes: Float
    lowest: float

    def __call__(self, reward: Reward, carry: Carry, step: Steps) -> tuple[Float, Float]:
        """One step from s, and one from where it leads."""
        near = self.after(step.previous_distance).ravel()
        first = _leading_to(rows_of(step, _each(len(step.distance), CHANGES)), near)
        remembered, here = pay(reward, _repeated(carry, CHANGES), first)
        best = np.minimum(first.previous_best, first.distance)
        state, after = {DISTANCE: first.distance}, {DISTANCE: self.after(step.distance).ravel()}
        following = step_between(state, after, first.begin_distance, best, first.step + 1.0)
        _, beyond = pay(reward, remembered, following)
        return _mean(here.total, CHANGES), _mean(beyond.total, CHANGES)

    def after(self, distance: Float) -> Float:
        """Distances after a step from `distance`, (n,), one for each A, (n, CHANGES), [m]."""
        group = np.searchsorted(self.edges, distance, side="right")
        after: Float = np.maximum(distance[:, None] + self.changes[group], self.lowest)
        return after


def anywhere(rollouts: Sequence[Rollout]) -> Anywhere:
    """Quantiles of the distances after the recorded steps of all scripts, each step weighing the same."""
    _, after = _recorded(rollouts)
    return Anywhere(np.quantile(after, _levels(SAMPLES)))


def nearby(rollouts: Sequence[Rollout]) -> Nearby:
    """Quantiles of the changes in the recorded steps of all scripts, by the distance before the step."""
    before, after = _recorded(rollouts)
    begins = np.unique(np.quantile(before, np.arange(GROUPS) / GROUPS, method="lower"))
    # A group begins at a recorded distance, so none is empty.
    group = np.searchsorted(begins[1:], before, side="right")
    change = after - before
    changes = [np.quantile(change[group == number], _levels(CHANGES)) for number in range(len(begins))]
    return Nearby(begins[1:], np.stack(changes), float(after.min()))


Coverage: TypeAlias = Callable[[Sequence[Rollout]], Expectation]
"""`anywhere` or `nearby`: where steps may lead, from what was recorded."""


def forms_of_distances(reward: Reward, rollouts: Sequence[Rollout], gamma: float) -> dict[str, Form]:
    """A reward of distances alone in EPIC's form and in DARD's, over all recorded steps.

    Args:
        reward: The reward.
        rollouts: One of each script.
        gamma: Discount per step.
    """
    coverages: dict[str, Coverage] = {EPIC: anywhere, DARD: nearby}
    return {form: centred_unit(*canonical_values(reward, rollouts, gamma, of)) for form, of in coverages.items()}


def canonical_values(
    reward: Reward, rollouts: Sequence[Rollout], gamma: float, coverage: Coverage
) -> tuple[Float, float]:
    """C of every recorded step, (transitions,), and the largest value that the reward paid for one."""
    expectation = coverage(rollouts)
    shaped, largest = [], 0.0
    for rollout in rollouts:
        # the last state has no step of its own: a step on the spot stands in, whose pay is not looked at
        states = {DISTANCE: np.vstack([rollout.distances, rollout.distances[-1:]])}
        with np.errstate(all="ignore"):
            rows = [
                (np.asarray(paid.total, np.float64), *expectation(reward, carry, step))
                for carry, step, paid in paid_along(reward, states)
            ]
        paid, expected, beyond = map(np.stack, zip(*rows, strict=True))  # of every state, (steps + 1, n)
        values = paid[:-1] + gamma * expected[1:] - expected[:-1] - gamma * beyond[:-1]
        shaped.append(values[rollout.running])
        largest = max(largest, float(np.abs(paid[:-1][rollout.running]).max()))
    return np.concatenate(shaped), largest


def _recorded(rollouts: Sequence[Rollout]) -> tuple[Float, Float]:
    """Distances before and after all recorded steps, (transitions,), [m]."""
    before = np.concatenate([rollout.distances[:-1][rollout.running] for rollout in rollouts])
    return before, np.concatenate([rollout.distances[1:][rollout.running] for rollout in rollouts])


def _levels(count: int) -> Float:
    """The middles of `count` equal parts of [0, 1]."""
    levels: Float = (np.arange(count) + 0.5) / count
    return levels


def _leading_to(step: Steps, distance: Float) -> Steps:
    """The same step, but that it leads to `distance`."""
    return step._replace(distance=distance, delta_distance=distance - step.previous_best)


def _mean(value: Any, count: int) -> Float:
    """The mean of each env's `count` values, (n * count,) to (n,)."""
    mean: Float = np.asarray(value, np.float64).reshape(-1, count).mean(axis=1)
    return mean


def _each(size: int, count: int) -> Ints:
    """The numbers of `size` envs, each `count` times."""
    return np.repeat(np.arange(size), count)


def _repeated(carry: Carry, count: int) -> Carry:
    """Each env's entry `count` times."""
    if isinstance(carry, tuple):
        return tuple(_repeated(part, count) for part in carry)
    return np.repeat(carry, count, axis=0)


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
RECORDED = (
    "These distances were computed from recorded transitions, because a reward reads {}, and not distances alone: each "
    "was asked what a recorded action pays between two recorded states."
)
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
    because = tuple(dict.fromkeys((*needed, *needed_beside_distances(against, others))))
    forms_in = forms_of_rollouts if because else forms_of_distances
    forms = {who: forms_in(it, rollouts, gamma) for who, it in ((other, against), (name, reward))}
    finishing = finishing_of(scores, gamma)
    asked = OfScripts(
        finishing,
        properties_of(reward, [rollout.distances[:, :TRIED] for rollout in rollouts], gamma, needed),
        {rollout.script: None for rollout in rollouts} if needed else workspace_ratios(reward, rollouts),
        needed,
        because,
        min(COMPARED, finishing.steps) if because else finishing.steps,
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
        measured=(
            f"{SCALE} {asked.compared:,} recorded steps were compared.",
            *([RECORDED.format(", ".join(because))] if because else []),
        ),
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
