"""From a world to what a cheat would do there: searched, judged, disturbed, tried elsewhere, and shown."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager, closing, nullcontext
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from harness.environment import AnyEnv
from harness.errors import UsageError, sentence
from harness.payoff.rollout import FRAGILE
from harness.recorder.env_facts import Columns
from harness.registry import Registry
from harness.reward.terms import paid_twice, paid_twice_text
from harness.text import number

from ..transitions.audit_rewards import GAMMA, ByName
from .behaviour import Behaviour, Role, Searched, Three
from .disturb import NOISES, Acting, noise_curve, paid_at, rested, strength_of
from .finding import NAMES, Finding
from .held_out import act_of
from .judge import Walks, judge
from .place import Place, blamed_at, elsewhere_of, world_at
from .table import TRAINING
from .world import Act, Shown, World

if TYPE_CHECKING:
    from ..audit import Audit

WATCHED = 16
"""So many episodes of a policy are looked at where chance decides."""


@dataclass(frozen=True)
class Search:
    """How much is searched.

    Attributes:
        budget: About so many steps are taken.
        starts: From so many starts.
        seed: Of the search and of its starts.
        folders: Experiments and recorded trainings that it begins from.
        policies: Policies that it begins from, ``FILE.py:NAME`` or a folder.
    """

    budget: int
    starts: int
    seed: int = 0
    folders: Sequence[Path] = ()
    policies: Sequence[str] = ()

    def draw_starts(self) -> tuple[int, ...]:
        """The seeds of the resets; no evaluation and no training has them."""
        drawn = np.random.default_rng([self.seed, *TRAINING]).choice(np.arange(*TRAINING), self.starts, replace=False)
        return tuple(map(int, drawn))


ARM, ENVIRONMENT = Search(budget=500_000, starts=8), Search(budget=600_000, starts=4)
"""What is usual: seconds for an arm, whose episodes are played side by side, a minute in an environment."""


def find_in(
    world: World,
    asked: Search,
    elsewhere: Mapping[str, Callable[[], World]] | None = None,
    policies: Mapping[str, Act] | None = None,
) -> Finding:
    """What a cheat would do in a world.

    Args:
        world: Where, and by which reward.
        asked: How much is searched.
        policies: By name, functions of an observation that the search begins from too.
        elsewhere: By the name of another simulator, makes the same world there; it is closed again.
    """
    from .beginnings import of_folder, policy_named, policy_of
    from .search import search

    starts = world.distinct(asked.draw_starts())
    begun = [
        *world.scripts(starts),
        *(policy_of(world, name, policy) for name, policy in (policies or {}).items()),
        *(policy_named(world, text) for text in asked.policies),
    ]
    told = list[str]()
    for folder in asked.folders:
        found, left_out = of_folder(world, folder)
        begun += found
        told += left_out
    searched = search(world, starts, asked.budget, asked.seed, begun)
    judged = judge(searched, world, _walks_in(world, searched))
    rng, rates = np.random.default_rng([asked.seed, asked.budget]), searched.rates
    given = {it.made_by: it.act for it in begun if it.act is not None}

    def acting(three: Three) -> dict[Role, Acting]:
        """The policies of behaviours that have one, found or given; from their starts, or many where chance decides."""
        found = dict[Role, Acting]()
        for role, of in three.items():
            act = given.get(of.made_by) if of.policy is None else act_of(of.policy, world)
            if act is not None:
                found[role] = act, rates["paid"].starts if rates else [of.start]
        return found

    three = judged.shown.three
    noise = noise_curve(world, three, acting(three), rng)
    strength = ""
    if cases := [case for case in judged.alarmed if case.word == judged.word]:
        tried = [(case, acting(case.three)) for case in cases]
        strength, stands, (tempting, task) = strength_of(world, tried, rng)
        count, is_fragile = len(cases), strength == FRAGILE
        on = f" on {count - stands if is_fragile else stands} of {count} starts" if count > 1 else ""
        told.append(
            f"{strength}: with action noise {NOISES[-1]:g} it {'no longer' if is_fragile else 'still'} pays more{on}. "
            f"On average the {NAMES[judged.shown.tempting]} then earns {number(tempting)}, the "
            f"{NAMES[judged.shown.against]} {number(task)}."
        )
    if rates and not world.is_repeated:
        told.append("The same seed and actions do not bring the same again: policies were searched, no sequences.")
    paid: dict[str, Mapping[Role, float]] = {}
    for name, make in (elsewhere or {}).items():
        with closing(make()) as other:
            paid[name] = dict(zip(three, paid_at(other, three.values()), strict=True))
        earned = ", ".join(f"the {NAMES[role]} {number(value)}" for role, value in paid[name].items())
        told.append(f"The same actions in {name} earn: {earned}.")
    shown = {role: world.show(of.start, of.actions) for role, of in three.items()}
    terms = [it.terms for it in shown.values() if len(it.terms) > 2]
    if terms:
        whole = {name: np.concatenate([it[name] for it in terms]) for name in terms[0] if name != "events"}
        if twice := paid_twice(whole):
            told.append(f"{sentence(paid_twice_text(twice, len(whole[twice])))}.")
    return Finding(
        world=world.name,
        reward=world.reward,
        gamma=world.gamma,
        success=world.success,
        word=judged.word,
        strength=strength,
        lines=(*judged.lines, *told, *world.notes),
        alarmed=tuple(next(iter(case.three.values())).start for case in judged.alarmed),
        starts=tuple(next(iter(of.values())).start for of in searched.plain),
        searched=searched,
        noise=noise,
        elsewhere=paid,
        shown=shown,
        three=three,
    )


def cheats_at(
    places: Sequence[Place],
    registry: Registry,
    asked: Search,
    watched: Callable[[World], AbstractContextManager[Any]] = nullcontext,
) -> tuple[Finding, ...]:
    """What a cheat would do at each place, one after the other.

    Args:
        places: Each with its reward.
        registry: The plugins.
        asked: How much is searched.
        watched: Around each search, told its world.

    Raises:
        UsageError: A reward is not known, or fails in a step.
        PluginError: An environment, or the reward of an arm, raises; says whose it is.
    """
    found = []
    for place in places:
        with blamed_at(place, registry), closing(world_at(place, registry)) as world, watched(world):
            found.append(find_in(world, asked, dict([*elsewhere_of(place, registry).items()][:1])))
    return tuple(found)


def find_cheats(
    env: AnyEnv | str | Callable[[], AnyEnv],
    rewards: ByName,
    *,
    success: str = "",
    behaviour: ByName | None = None,
    policies: Mapping[str, Act] | None = None,
    gamma: float = GAMMA,
    budget: int = ENVIRONMENT.budget,
    starts: int = ENVIRONMENT.starts,
    seed: int = 0,
) -> "Audit":
    """What a cheat would do for each reward in any Gymnasium environment that ``reset(seed)`` makes repeat.

    Args:
        env: One that was made, which is left open; the id of one; or a function that makes one.
        rewards: As of `harness.RecordRewards`; what the env pays is ``"own"``.
        success: What tells success: a measure or a key of info, ``"height>0.9"``; empty to find one.
        behaviour: Measures of what is done, as of `harness.RecordRewards`; no reward enters them.
        policies: By name, from an observation to an action: the search begins from them too.
        gamma: The learner's discount per step, above 0 and at most 1.
        budget: About so many steps are taken for each reward.
        starts: From so many starts.
        seed: Of the search: the same one finds the same.

    Returns:
        An audit with one `Finding` for each reward in `cheats`; it prints as ``harness audit`` does.

    Raises:
        UsageError: Something of that cannot be used, or a reward fails in a step.
    """
    from ..audit import Audit
    from .environment_world import of_env

    if not rewards:
        raise UsageError("rewards={}: name at least one, such as {'own': 'own'}, what the env pays")
    if not 0.0 < gamma <= 1.0:
        raise UsageError(f"gamma={gamma:g}: must be above 0 and at most 1")
    for name, value, least in (("budget", budget, 1), ("starts", starts, 1), ("seed", seed, 0)):
        if value < least:
            raise UsageError(f"{name}={value}: must be at least {least}")
    columns = Columns(dict(rewards), dict(behaviour or {}))
    found = []
    for reward in rewards:
        with closing(of_env(env, reward, columns, gamma, success)) as world:
            found.append(find_in(world, Search(budget, starts, seed), policies=policies))
    where = found[0].world
    return Audit(
        title=f"{where}: rewards {', '.join(rewards)}; discount {gamma:g}",
        facts={"env": where, "gamma": gamma},
        rewards=tuple(rewards),
        cheats=tuple(found),
    )


def _walks_in(world: World, searched: Searched) -> Walks:
    """The episodes of a behaviour that succeed: the one that was kept, or those of its policy where chance decides.

    What was kept is played side by side, when the first one is asked for.
    """
    if searched.rates is not None:
        starts = searched.rates["paid"].starts[:WATCHED]

        def of_policy(behaviour: Behaviour) -> list[Shown]:
            assert behaviour.policy is not None
            act = act_of(behaviour.policy, world)
            return [it for it in (world.watch(start, act) for start in starts) if it.success[-1]]

        return of_policy

    @cache
    def kept() -> dict[Behaviour, Shown]:
        threes = (*searched.plain, *searched.discounted)
        asked = [*dict.fromkeys(of for it in threes for of in it.values() if of.success)]
        actions = np.stack([rested(world, of.actions) for of in asked])
        return dict(zip(asked, world.played(np.array([of.start for of in asked]), actions), strict=True))

    return lambda behaviour: [kept()[behaviour]]
