"""Links from a number into the replay, to an episode that shows it. The title of a link names the episode."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from harness.eta.behaviour_change import Change
from harness.eta.headline import SUCCESS
from harness.report.replay.stick import draw_sticks
from harness.report.rows.behaviour import text_of
from harness.results.comparison import Comparison
from harness.results.replay import Episode, Outcome, Show

BASELINE, PROPOSED = 0, 1
"""Places of the sides in a show."""
ENDS: tuple[Outcome, ...] = ("reached", "time-out", "ground", "obstacle")
"""The ways to end, in the order in which a link looks for them."""


class Link(NamedTuple):
    """A link of the page."""

    address: str
    title: str
    """Which episode it is, and what it shows."""


class Still(NamedTuple):
    """The end of a pair of episodes, as the first screen shows it."""

    show: int
    """Number of its show, from 0."""
    ends: tuple[str, ...]
    """The reward of each side, and how its episode ended."""
    share: str
    """How often pairs end so."""
    link: Link
    """To the pair in the replay."""
    otherwise: str
    """How many pairs end otherwise; empty if none does."""
    other: Link | None
    """To one of them."""
    sticks: tuple[str, ...]
    """The end of each side as SVG, for where no script draws it."""


@dataclass(frozen=True)
class EpisodeLinks:
    """Links to the episodes of one comparison.

    Attributes:
        place: Number of the show on the page, from 1.
        show: The show, with episodes under both rewards.
    """

    place: int
    show: Show

    def ending(self, side: int, outcome: str) -> Link | None:
        """A link to the first episode that ended so under the side's reward; None if no such episode is shown."""
        for index, episode in enumerate(self.show.sides[side].episodes):
            if episode.outcome == outcome:
                return self._link(side, index, outcome)
        return None

    def showing(self, side: int, change: Change) -> Link | None:
        """To the shown episode whose value is nearest to a measure's mean; None where none has a value.

        Of a measure that is 0 or 1 in every episode, a share, to an episode that it counts, if there is one.
        """
        mean = change.proposed if side == PROPOSED else change.baseline
        found = enumerate(self.show.sides[side].episodes)
        values = {index: value for index, it in found if (value := it.values.get(change.name)) is not None}
        if mean is None or not values:
            return None
        wanted = 1.0 if set(values.values()) <= {0.0, 1.0} else mean
        index = min(values, key=lambda index: abs(values[index] - wanted))
        return self._link(side, index, self._told(change, values[index], self.show.sides[side].episodes[index]))

    @property
    def success(self) -> dict[str, Link | None]:
        """Links by column of the overview: to an episode that reached the target, else to one that failed."""
        return {
            column: next(filter(None, (self.ending(side, end) for end in ENDS)), None)
            for side, column in ((BASELINE, "success, baseline"), (PROPOSED, "success, proposed"))
        }

    @property
    def kinds(self) -> list[tuple[str, Link]]:
        """How often pairs end so, and a link to the typical one, of each way to end; the most frequent one first."""
        pairs = self.show.pairs
        if pairs is None:
            return []
        return [
            (pairs.share(kind), self._pair(index))
            for kind in pairs.counts
            if (index := self.show.kinds.get(kind)) is not None
        ]

    @property
    def still(self) -> "Still":
        """What stands beside the answer: the pair that is shown first, and what it is typical of."""
        index, told, pairs, sides = self.show.first, self.kinds, self.show.pairs, self.show.sides
        names = [side.title.partition(": ")[2] or side.title for side in sides]
        others = [link for _, link in told[1:2]]
        return Still(
            self.place - 1,
            tuple(f"{name}: {side.episodes[index].outcome}" for name, side in zip(names, sides, strict=True)),
            told[0][0] if told else "",
            self._pair(index),
            pairs.otherwise if pairs is not None and others else "",
            others[0] if others else None,
            draw_sticks(sides, index),
        )

    def _told(self, change: Change, value: float, episode: Episode) -> str:
        name = change.name.replace("_", " ")
        if change.name == SUCCESS:
            return episode.outcome
        return f"{name} {text_of(change.measure)(value)}, {episode.outcome}"

    def _pair(self, index: int) -> Link:
        """A link to a pair, and how it ended under both rewards. It is said once if it is the same."""
        return self._link(
            BASELINE, index, " | ".join(dict.fromkeys(it.episodes[index].outcome for it in self.show.sides))
        )

    def _link(self, side: int, index: int, told: str) -> Link:
        number, seed = self.show.numbers[index], self.show.sides[side].seeds[index]
        return Link(f"#replay-{self.place}-{number}-{seed}", f"Watch episode {number} of seed {seed}: {told}")


def links_of(shows: Sequence[Show], combinations: Sequence[Comparison]) -> list[EpisodeLinks | None]:
    """The links of each comparison; None if it has no episodes to show."""
    found = {id(show.comparison): EpisodeLinks(place, show) for place, show in enumerate(shows, start=1)}
    return [found.get(id(comparison)) for comparison in combinations]
