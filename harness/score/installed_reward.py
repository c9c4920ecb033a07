"""Pays recorded runs again by a reward of the experiment, or says why that is not possible any more."""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cached_property

import numpy as np

from harness.arrays import Float
from harness.errors import HarnessError, Unscored, one_line
from harness.record.trace import Trace
from harness.registry.choice import Choice
from harness.registry.registry import Registry
from harness.registry.sources import fingerprint
from harness.reward import Reward
from harness.reward.needs import needs_of
from harness.score.scorer import fields_beside_distances, score_trace


class InstalledReward:
    """A reward of the experiment, as it is installed now.

    Attributes:
        choice: The reward.
    """

    def __init__(self, choice: Choice, registry: Registry) -> None:
        self.choice, self._registry = choice, registry

    @cached_property
    def fingerprint(self) -> str:
        """The fingerprint of its parameters and sources; see `harness.registry.sources.fingerprint`.

        Raises:
            Unscored: There is no such reward any more.
        """
        with self._told():
            return f"{self.choice.to_json()} {fingerprint(self._reward)}"

    @cached_property
    def reads_more(self) -> bool:
        """Whether it reads more of a run than distances.

        Raises:
            Unscored: It cannot be asked.
        """
        with self._told():
            return bool(fields_beside_distances(needs_of(self._reward).fields))

    def pay(self, run: Trace) -> Float:
        """The shaped reward of every row of a run, (rows,).

        Raises:
            Unscored: It cannot, or what it pays is not finite.
        """
        with self._told():
            paid = score_trace(self._reward, run)
            if not np.isfinite(paid).all():
                raise HarnessError(f"reward {self.choice.label} is not finite on the runs of another reward")
            return paid

    def pays_recorded(self, own: Trace) -> bool:
        """Whether it pays what is recorded, except for last bits, in which another machine may differ.

        Args:
            own: What it paid itself, with the column ``reward``.

        Raises:
            Unscored: It cannot pay at all.
        """
        with self._told():
            return np.allclose(score_trace(self._reward, own), own["reward"], rtol=1e-9, atol=1e-12)

    def require_unchanged(self, pays_recorded: bool) -> None:
        """Check `pays_recorded`. A reward that now pays its own steps differently is another reward.

        Raises:
            Unscored: It has changed.
        """
        if not pays_recorded:
            raise Unscored(f"reward {self.choice.label} now pays its recorded steps differently: it has changed")

    @cached_property
    def _reward(self) -> Reward:
        if ("rewards", self.choice.name) not in self._registry.specs:
            raise HarnessError(
                f"No reward '{self.choice.name}' is installed. If it stands in a file, add --plugin FILE"
            )
        reward: Reward = self.choice.build(self._registry, "rewards")
        return reward

    @contextmanager
    def _told(self) -> Iterator[None]:
        """Turn any error of a reward into a reason, so that the rest can still be reported."""
        try:
            yield
        except HarnessError as error:  # one that is not installed any more
            raise Unscored(str(error)) from error
        except (Exception, SystemExit) as error:  # one that is, and cannot any more: a plugin may raise anything
            raise Unscored(f"reward {self.choice.label} could not score the runs: {one_line(error)}") from error
