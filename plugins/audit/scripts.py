"""A reward on the scripted movements of an arm: everything is asked of it. Trains nothing."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace

import numpy as np

from harness.errors import UsageError
from harness.eta import SHARE
from harness.log.log import SUCCESS
from harness.payoff.rollout import (
    CREEP,
    FINISH,
    HOLD,
    HOVER,
    NOISE,
    NoScriptsError,
    Rollout,
    Score,
    discounted_sum,
    finishing_of,
    on_finishing,
    on_noise,
    on_terms,
    rollouts_by_noise,
    score_rollout,
)
from harness.registry import Choice, Registry, choose
from harness.results.recordings.episodes import Episodes
from harness.reward import Reward
from harness.text import number

from .audit import Audit, OfScripts
from .distance import compare_forms
from .probe import needed_beside_distances
from .properties import properties_of, workspace_ratios
from .recorded.earned import earned_by
from .recorded.pair import Paid, compare_paid, pair_of
from .recorded.pair_grid import SCALE
from .search.place import GAMMA_OF_ARM, arm_at, places_on_task
from .subject import Answered, Asked
from .transitions.rollout_forms import COMPARED, forms_of_rollouts


def verdict_of(found: OfScripts) -> list[str]:
    """One line on finishing, and one for whatever else needs a warning."""
    of = found.finishing
    payoffs = {payoff.policy: payoff for payoff in of.payoffs}
    lines = [on_finishing(of)]
    if found.disturbed is not None and (of.undiscounted or of.discounted):
        lines.append(on_noise(of, found.disturbed))
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
        min(COMPARED, finishing.steps),
        finishing_of([score_rollout(reward, rollout) for rollout in disturbed], gamma) if disturbed else None,
    )
    by_name = {other: others, name: scores}
    paid = Paid(  # without the events, which the task pays under either
        {who: np.concatenate([of.values[of.rollout.running] for of in each]) for who, each in by_name.items()},
        {who: np.concatenate([discounted_sum(of.values, 1.0) for of in each]) for who, each in by_name.items()},
        can_end=any(it.reached.any() for it in rollouts),
    )
    apart = compare_forms(other, forms[other], name, forms[name])
    pair = pair_of(other, name, [compare_paid(paid, other, name)], [apart])
    return Audit(
        title=name,
        setting=(setting,) if setting else (),
        facts={},
        rewards=tuple(by_name),
        pairs=(pair,),
        earned=tuple(
            earned_by(
                rollout.script,
                [_episodes(rollout, {who: each[at] for who, each in by_name.items()})],
                tuple(by_name),
                {SUCCESS: SHARE, STEPS: (0.0, float(max(len(it.running) for it in rollouts)))},
            )
            for at, rollout in enumerate(rollouts)
        ),
        success=SUCCESS,
        verdict=tuple(verdict_of(asked)),
        scripts=asked,
        measured=(f"{SCALE} {asked.compared:,} recorded steps were compared.",),
    )


def _episodes(rollout: Rollout, scores: Mapping[str, Score]) -> Episodes:
    """The episodes of one rollout, the events among what they were paid."""
    returns = {name: discounted_sum(score.paid, 1.0) for name, score in scores.items()}
    measures = {SUCCESS: np.asarray(rollout.reached, np.float64), STEPS: rollout.steps}
    return Episodes(np.cumsum(rollout.steps).astype(np.int64) - 1, returns, measures, {})


def audited(asked: Asked) -> Answered:
    """An audit of each reward of a task by scripts, where they can do the task, and where a search looks.

    Raises:
        UsageError: A name is not known, a number is too small, or a reward fails.
        NoScriptsError: Scripts cannot do the task, and nothing is searched.
    """
    registry = asked.registry
    if not asked.rewards:
        raise UsageError("Missing option '--reward'; or name an environment, or a folder of recorded trainings")
    choices = [choose(registry, "rewards", name) for name in asked.rewards]
    episodes = 100 if asked.episodes is None else asked.episodes
    gamma = GAMMA_OF_ARM if asked.gamma is None else asked.gamma
    if episodes < 1:
        raise UsageError(f"--episodes {episodes}: must be at least 1")
    if not 0.0 < gamma <= 1.0:
        raise UsageError(f"--gamma {gamma:g}: must be above 0 and at most 1")
    compared = choose(registry, "rewards", asked.against or "baseline")
    places = places_on_task(registry, choices, asked.named, asked.robot, asked.sim, gamma)
    at = places[0]
    arm = arm_at(at, registry)
    label = at.simulator.label if at.simulator else "no simulator: joints move exactly as commanded"
    try:
        rollouts, disturbed = rollouts_by_noise(arm.simulator, arm.robot, arm.task, episodes, (0.0, NOISE))
    except NoScriptsError as error:
        if asked.search is None:
            raise
        unasked = (f"Not asked of scripts: {error}.",)
        facts = [{"reward": it.label, "task": asked.named} for it in choices]
        return [Audit(title=of["reward"], facts=of, rewards=(of["reward"],), not_asked=unasked) for of in facts], places
    *judged, other = (choice.build(registry, "rewards") for choice in (*choices, compared))
    with _named(compared, registry):
        score_rollout(other, rollouts[0])
    setting = f"{label} · {at.robot} · {at.task.label} · {episodes} episodes of at most {arm.task.horizon} steps"
    told = {"simulator": label, "robot": at.robot, "task": at.task.label, "episodes": episodes}
    found = []
    for choice, reward in zip(choices, judged, strict=True):
        with _named(choice, registry):
            audit = audit_reward(reward, other, rollouts, gamma, (choice.label, compared.label), setting, disturbed)
        found.append(replace(audit, facts={"reward": choice.label, "against": compared.label, **told}))
    return found, places


@contextmanager
def _named(choice: Choice, registry: Registry) -> Iterator[None]:
    """Whatever a reward raises in this block is said to be the reward's."""
    try:
        with choice.blamed(registry, "rewards", "it was audited"):
            yield
    except UsageError as error:
        raise UsageError(f"Reward '{choice.label}': {error}") from error
