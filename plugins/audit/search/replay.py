"""Behaviours played again: before they are certified, and from the file of a certificate, wherever that is."""

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, replace

import numpy as np
from scipy import stats

from harness.arrays import Float
from harness.text import number

from .behaviour import ROLES
from .certificate import Certificate, rating_text
from .finding import Finding
from .held_out import act_of
from .place import Place
from .world import Data, Outcomes, Shown, World

LEAST_P = 0.05
"""Pay that differs between two plays of a policy by more than chance would in one of twenty is another pay."""


@dataclass(frozen=True)
class Difference:
    """Where an episode that was played again differs first.

    Attributes:
        step: From 1.
        what: What was different there.
        came_to: What both came to, in words.
    """

    step: int
    what: str
    came_to: str

    def __str__(self) -> str:
        return f"step {self.step}: {self.what}; {self.came_to}"


@dataclass(frozen=True)
class Replayed:
    """What came of playing a certificate again.

    Attributes:
        certificate: What was played.
        shown: What it was here.
        difference: Where it differs first; None if it is the same, bit for bit.
        reasons: Why it may differ, a line each.
        elsewhere: The simulator in which it was played, if that is another one than the certificate's.
        rating: What its policy came to here, where chance decides.
    """

    certificate: Certificate
    shown: Shown
    difference: Difference | None
    reasons: tuple[str, ...]
    elsewhere: str
    rating: Data | None = None

    @property
    def is_refused(self) -> bool:
        """Whether it does not show what it says."""
        then, now = self.certificate.rating, self.rating
        if then is not None and now is not None:
            return not agree(then, now)
        return self.difference is not None and not self.elsewhere

    @property
    def lines(self) -> tuple[str, ...]:
        """The answer, and what it rests on."""
        then, now = self.certificate.rating, self.rating
        if then is not None and now is not None:
            same = np.array_equal(then["paid"], now["paid"])
            word = "the same" if same else "about the same" if agree(then, now) else "NOT THE SAME, refused"
            told = f"{word}: {rating_text(now)}"
            return (told,) if same else (f"{told}; the file says {rating_text(then)}", *self.reasons)
        if self.elsewhere:
            told = came_to(self.certificate.shown)
            return (f"in {self.elsewhere}: {came_to(self.shown)}; the file says {told}",)
        if self.difference is None:
            return (f"the same: {came_to(self.shown)}", *self.reasons)
        return (f"NOT THE SAME, refused. {self.difference}", *self.reasons)

    def to_json(self) -> Data:
        """Plain data."""
        found = self.difference
        rating = {"rating": self.rating} if self.rating is not None else {}
        return {
            "same": found is None if self.rating is None else not self.is_refused,
            **rating,
            "paid": math.fsum(self.shown.paid),
            "steps": len(self.shown.paid),
            "success": bool(self.shown.success[-1]),
            "certified": {
                "paid": self.certificate.paid,
                "steps": len(self.certificate.shown.paid),
                "success": bool(self.certificate.shown.success[-1]),
            },
            "first_difference": found and {"step": found.step, "what": found.what},
            "reasons": list(self.reasons),
            "elsewhere": self.elsewhere,
        }


def agree(then: Data, now: Data) -> bool:
    """Whether two plays of one policy are paid the same but for chance; by Welch's test."""
    one, other = then["paid"], now["paid"]
    if one == other or np.ptp(one) == np.ptp(other) == 0.0:
        return bool(one[0] == other[0])
    return bool(stats.ttest_ind(one, other, equal_var=False).pvalue >= LEAST_P)


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
        for role in ROLES:
            shown = finding.shown.get(role)
            if shown is None:
                continue
            searched, policy = finding.searched, finding.three[role].policy
            rates = searched.rates
            known = [] if rates is None else vars(rates).values()
            rated = next((it for it in known if it is not None and it.policy is policy), None)
            now, why = None, ""
            if rated is not None:
                then, now = rating_of(rated.outcomes, rated.starts), rate(rated.policy, rated.starts, world)
                if not agree(then, now):
                    why = f"not certified. Played again, {rating_text(now)}, not {rating_text(then)}"
            else:
                again = _played_twice(shown, world)
                if found := difference(shown, again[0]) or difference(shown, again[1]):
                    why = f"not certified, it does not repeat. Played again, {found}"
                shown = again[0]
            if why:
                refused.append(f"{finding.reward}, {role}: {why}")
                continue
            certificates.append(
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
                        "made_by": finding.three[role].made_by,
                        "seed": seed,
                        "budget": budget,
                        "steps": searched.steps,
                        "how": list(searched.how),
                    },
                    shown,
                    tuple(row for row in finding.noise if row.role == role),
                    {name: paid[role] for name, paid in finding.elsewhere.items() if role in paid},
                    policy=None if rated is None else dict(rated.policy),
                    rating=now,
                )
            )
    return certificates, refused


def replay(certificate: Certificate, world: World, reasons: Sequence[str] = (), elsewhere: str = "") -> Replayed:
    """Play a certificate twice in a world.

    Args:
        certificate: What to play.
        world: A fresh one.
        reasons: What is other here than it was.
        elsewhere: The simulator of `world`, if it is another one.
    """
    then = certificate.shown
    if certificate.policy is not None and certificate.rating is not None:
        rating = rate(certificate.policy, certificate.rating["starts"], world)
        return Replayed(certificate, then, None, tuple(reasons), elsewhere, rating)
    again = _played_twice(then, world)
    if unsteady := difference(*again):
        return Replayed(certificate, again[0], unsteady, ("It does not repeat itself here.",), elsewhere)
    found = difference(then, again[0])
    if found is not None and not reasons:
        reasons = ("Nothing that is recorded has changed: what it depends on beside that is not known.",)
    return Replayed(certificate, again[0], found, tuple(reasons), elsewhere)


def rate(policy: Data, starts: Sequence[int], world: World) -> Data:
    """What a policy comes to from some starts."""
    outcomes, _ = world.act(np.array(starts, np.int64), act_of(policy, world))
    return rating_of(outcomes, starts)


def rating_of(outcomes: Outcomes, starts: Sequence[int]) -> Data:
    """Some episodes as a certificate has them, see `RatingForm`."""
    paid, success = outcomes.paid.tolist(), outcomes.success.astype(int).tolist()
    return {"starts": list(map(int, starts)), "paid": paid, "success": success}


def difference(then: Shown, now: Shown) -> Difference | None:
    """Where two plays of the same actions differ first, bit for bit; None if nowhere."""
    both = min(len(then.paid), len(now.paid))
    told = f"in all {came_to(now)}, not {came_to(then)}"
    names, none = dict.fromkeys([*then.terms, *now.terms]), np.zeros(0)
    rows = {"the step": (then.paid, now.paid)}
    rows |= {f"its term {name}": (then.terms.get(name, none), now.terms.get(name, none)) for name in names}
    first = {name: _first(a[:both], b[:both]) for name, (a, b) in rows.items()}
    success = _first(then.success[:both].astype(float), now.success[:both].astype(float))
    step = min(*first.values(), success)
    if step < both:
        what = []
        for name, values in rows.items():
            if first[name] == step:
                paid = [repr(float(it[step])) if step < len(it) else "nothing" for it in values]
                what.append(f"{name} pays {paid[1]}, not {paid[0]}")
        if success == step:
            what.append("it is a success" if now.success[step] else "it is no success")
        return Difference(step + 1, "; ".join(what), told)
    if len(then.paid) != len(now.paid):
        return Difference(both + 1, f"the episode {'goes on' if len(now.paid) > both else 'has ended'}", told)
    if then.ended != now.ended:
        return Difference(both, f"the episode was {now.ended}, not {then.ended}", told)
    return None


def changes(then: Mapping[str, Data], now: Mapping[str, Data]) -> tuple[str, ...]:
    """What is other now than it was, of versions, sources and the machine, a line each; see `RunsOnForm`."""
    versions = dict.fromkeys([*then["versions"], *now["versions"]])
    return (
        *(
            f"{name} is {now['versions'].get(name, 'missing')} here, and was {then['versions'].get(name, 'missing')}."
            for name in versions
            if then["versions"].get(name) != now["versions"].get(name)
        ),
        *(
            f"The source of the {name} is another one."
            for name, digest in then["sources"].items()
            if now["sources"].get(name) not in (None, digest)
        ),
        *(
            f"The machine is another one: {now['machine'].get('cpu')}, and was {then['machine'].get('cpu')}."
            for _ in range(any(then["machine"].get(key) != now["machine"].get(key) for key in ("cpu", "cpu_flags")))
        ),
    )


def came_to(shown: Shown) -> str:
    """What an episode was paid in how many steps."""
    success = ", with success" if shown.success[-1] else ""
    return f"{number(math.fsum(shown.paid))} in {len(shown.paid)} steps{success}"


def _played_twice(shown: Shown, world: World) -> list[Shown]:
    """An episode of the same actions, twice; where it goes on, the last action is repeated."""
    rest = max(0, world.horizon - len(shown.actions))
    actions = np.concatenate([shown.actions, np.repeat(shown.actions[-1:], rest, axis=0)])
    return [world.show(shown.start, actions) for _ in range(2)]


def _first(one: Float, other: Float) -> int:
    """The first row that differs in a bit; the number of rows of the longer one if none does."""
    both = min(len(one), len(other))
    differs = np.flatnonzero(one[:both].view(np.int64) != other[:both].view(np.int64))
    return int(differs[0]) if len(differs) else both if len(one) != len(other) else len(one)
