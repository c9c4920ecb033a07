"""Behaviours played again: before they are certified, and from the file of a certificate, wherever that is."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from itertools import zip_longest
from typing import Any, NamedTuple

import numpy as np

from harness.files.plain import to_plain
from harness.text import number, shortened

from .certificate import Certificate, DisturbedForm, rating_text
from .disturb import paid_at
from .finding import Finding
from .held_out import act_of
from .place import Place
from .world import Data, Outcomes, World

LEAST_P = 0.025
"""Pay, or success, that differs between two plays of a policy by more than chance would in one of forty is another."""
SEARCHED = ("answer", "found", "noise", "film", "role", "place.horizon")
"""Fields that a replay does not find again: what a search said, how it searched, its random noise, pictures, which of
the successes it is (a failure does not succeed), and after how many steps an episode that goes on is cut."""
STEPS = ("paid.terms.", "paid.steps", "behaviour.success", "behaviour.measures.")
"""Fields of steps, by what they begin with: the first step that differs says most."""
SHORT = 60
"""Characters of a value that differs."""


class Difference(NamedTuple):
    """Where a certificate that was played again differs first."""

    field: str
    """Its path in the file, ``paid.steps``."""
    number: int
    """Which of its values, from 1."""
    was: str
    """What is said there."""
    here: str
    """What it is here."""

    def __str__(self) -> str:
        return f"number {self.number} of {self.field} was {self.was}, and is {self.here} here"


@dataclass(frozen=True)
class Replayed:
    """What came of playing a certificate again.

    Attributes:
        certificate: What was played.
        found: What it is here; the same in what was not played again.
        difference: Where it differs first; None if it is the same, bit for bit.
        reasons: Why it may differ, a line each.
        elsewhere: The simulator in which it was played, if that is another one than the certificate's.
        unplayed: The fields that were not played again.
    """

    certificate: Certificate
    found: Certificate
    difference: Difference | None
    reasons: tuple[str, ...]
    elsewhere: str
    unplayed: tuple[str, ...]

    @property
    def is_refused(self) -> bool:
        """Whether it does not show what it says."""
        return self.difference is not None and not self.elsewhere

    @property
    def lines(self) -> tuple[str, ...]:
        """The answer, and what it rests on."""
        then, now = came_to(self.certificate), came_to(self.found)
        if self.elsewhere:
            return (f"in {self.elsewhere}: {now}; the file says {then}",)
        if self.is_refused:
            return (f"NOT THE SAME, refused. {self.difference}; in all {now}, not {then}", *self.reasons)
        is_about = self.found.rating != self.certificate.rating
        searched = self.certificate.found
        return (
            f"about the same: {now}; the file says {then}" if is_about else f"the same: {now}",
            *self.reasons,
            f"Not played again, and not confirmed: {', '.join(self.unplayed)}. The search says them again: --seed "
            f"{searched['seed']} --budget {searched['budget']} --starts {self.certificate.answer['starts']}",
        )

    def to_json(self) -> Data:
        """Plain data."""
        then, now = (
            {"paid": it.paid, "steps": len(it.shown.paid), "success": bool(it.shown.success[-1])}
            for it in (self.certificate, self.found)
        )
        return {
            "same": self.difference is None,
            "rating": self.found.rating,
            **now,
            "certified": then,
            "first_difference": to_plain(self.difference),
            "reasons": list(self.reasons),
            "elsewhere": self.elsewhere,
            "not_played_again": list(self.unplayed),
        }


def certify(
    finding: Finding,
    place: Place,
    make: Callable[[], World],
    runs_on: Mapping[str, Data],
    *,
    seed: int,
    budget: int,
) -> tuple[list[Certificate], list[str]]:
    """A certificate of each shown behaviour that repeats, and a line for each that does not.

    Args:
        finding: What a search found.
        place: What makes its world again.
        make: Makes it, anew at each call.
        runs_on: Versions, machine and sources.
        seed: Of the search.
        budget: Steps that it might take.
    """
    certificates, refused = list[Certificate](), list[str]()
    with closing(make()) as world:
        place = replace(place, horizon=world.horizon)
        for role, shown in finding.shown.items():
            searched, behaviour = finding.searched, finding.three[role]
            rated = [it for it in (searched.rates or {}).values() if it.policy is behaviour.policy]
            found = replay(
                Certificate(
                    role,
                    {
                        "word": finding.word,
                        "strength": finding.strength,
                        "lines": list(finding.lines),
                        "alarmed": len(finding.alarmed),
                        "starts": len(finding.starts),
                    },
                    place,
                    runs_on,
                    {
                        "made_by": behaviour.made_by,
                        "seed": seed,
                        "budget": budget,
                        "steps": searched.steps,
                        "how": list(searched.how),
                    },
                    shown,
                    [
                        {name: getattr(row, name) for name in DisturbedForm.__annotations__}
                        for row in finding.noise
                        if row.role == role
                    ],
                    {name: paid[role] for name, paid in finding.elsewhere.items() if role in paid},
                    policy=behaviour.policy if rated else None,
                    rating=rating_of(rated[0].outcomes, rated[0].starts) if rated else None,
                ),
                world,
            )
            if found.is_refused:
                refused.append(f"{finding.reward}, {role}: not certified. Played again, {found.difference}")
            else:
                certificates.append(found.found)
    return certificates, refused


def replay(
    certificate: Certificate,
    world: World,
    reasons: Sequence[str] = (),
    elsewhere: str = "",
    place: Place | None = None,
    others: Mapping[str, Callable[[], World]] | None = None,
) -> Replayed:
    """Play a certificate twice in a world, and compare all that it says but for what is told as not played again.

    Args:
        certificate: What to play.
        world: A fresh one.
        reasons: What is other here than it was.
        elsewhere: The simulator of `world`, if it is another one.
        place: Its place, as all in it is called here; None for the certificate's own.
        others: By the names of other simulators, what makes the same world there.
    """
    shown, policy, rating, there = certificate.shown, certificate.policy, certificate.rating, dict[str, float]()
    for name, make in (others or {}).items():
        with closing(make()) as other:
            (there[name],) = paid_at(other, [shown])
    place = replace(place or certificate.place, success=world.success, horizon=world.horizon)
    then = replace(certificate, place=place, elsewhere={**certificate.elsewhere, **there})
    found, again = _played(then, world), _played(then, world)
    unsteady = _first(found, again)
    unplayed = [*SEARCHED, *(f"elsewhere.{name}" for name in certificate.elsewhere if name not in there)]
    if policy is None or rating is None:
        differs = unsteady or _first(certificate, found)
    else:
        unplayed.append("policy (elsewhere)")
        rated = rate(policy, rating["starts"], world)
        found = replace(found, role=certificate.role, rating=rated)
        differs = _first(certificate, found)
        if differs and (reasons or unsteady or rate(policy, rating["starts"], world) != rated):  # by chance
            unplayed += ["start", "actions", "paid", "behaviour"]
            alike = rating if all(_is_alike(rating[name], rated[name]) for name in ("paid", "success")) else rated
            differs = _first(certificate, replace(found, shown=shown, rating=alike))
            found = replace(found, shown=shown)
    if unsteady and differs is unsteady:
        reasons = ("It does not repeat itself here.",)
    elif differs and not reasons:
        reasons = ("Nothing that is recorded has changed: what it depends on beside that is not known.",)
    return Replayed(certificate, found, differs, tuple(reasons), elsewhere, tuple(unplayed))


def rate(policy: Data, starts: Sequence[int], world: World) -> Data:
    """What a policy comes to from some starts."""
    outcomes, _ = world.act(np.array(starts, np.int64), act_of(policy, world))
    return rating_of(outcomes, starts)


def rating_of(outcomes: Outcomes, starts: Sequence[int]) -> Data:
    """Some episodes as a certificate has them, see `RatingForm`."""
    paid, success = outcomes.paid.tolist(), outcomes.success.astype(int).tolist()
    return {"starts": list(map(int, starts)), "paid": paid, "success": success}


def differences(then: Data, now: Data) -> list[Difference]:
    """Where plain data says something that other data does not, by field; those of the first step come first."""
    found, here = list[Difference](), dict(_fields(now))
    for name, values in _fields(then):
        for at, both in enumerate(zip_longest(map(repr, values), map(repr, here.get(name, ())), fillvalue="nothing")):
            if both[0] != both[1]:
                found.append(Difference(name, at + 1, *(shortened(it, SHORT) for it in both)))
                break
    return sorted(found, key=lambda it: (not it.field.startswith(STEPS), it.number))


def _fields(data: Any, name: str = "") -> Iterator[tuple[str, Sequence[Any]]]:
    """Each field of plain data by its path, ``paid.steps``, with its values."""
    if isinstance(data, list) and data and isinstance(data[0], Mapping):
        data = dict(enumerate(data))
    if isinstance(data, Mapping):
        for key, value in data.items():
            yield from _fields(value, f"{name}.{key}".lstrip("."))
    else:
        yield name, data if isinstance(data, list) else [data]


def _first(then: Certificate, now: Certificate) -> Difference | None:
    return next(iter(differences(then.to_json(), now.to_json())), None)


def came_to(certificate: Certificate) -> str:
    """What an episode was paid in how many steps, or a policy on average."""
    if certificate.rating:
        return rating_text(certificate.rating)
    return f"{number(certificate.paid)} in {len(certificate.shown.paid)} steps, {certificate.outcome}"


def _played(certificate: Certificate, world: World) -> Certificate:
    """It as an episode of the same actions shows it; where that goes on, the last action is repeated."""
    then, role = certificate.shown, certificate.role
    rest = np.repeat(then.actions[-1:], max(0, world.horizon - len(then.actions)), axis=0)
    shown = world.show(then.start, np.concatenate([then.actions, rest]))
    is_success = bool(shown.success[-1])
    if is_success != (role != "failure"):
        role = "success" if is_success else "failure"
    return replace(certificate, shown=shown, role=role)


def _is_alike(one: Sequence[float], other: Sequence[float]) -> bool:
    """Whether two plays of one policy are alike but for chance, by Welch's test."""
    if one == other or np.ptp(one) == np.ptp(other) == 0.0:
        return bool(one[0] == other[0])
    from scipy.stats import ttest_ind  # here, since importing it takes a second that few replays need

    return bool(ttest_ind(one, other, equal_var=False).pvalue >= LEAST_P)
