"""Pays recorded runs again by a reward of the experiment, or says why that is not possible any more."""

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cached_property
from typing import TypeGuard

import numpy as np

from harness.errors import HarnessError, SchemaError, Unscored, one_line
from harness.log import Log
from harness.log.log import UNCOUNTABLE, is_countable
from harness.record.trace import TERM, terms_of
from harness.registry.choice import Choice, Registry
from harness.registry.sources import fingerprint
from harness.reward import Paid, Reward
from harness.reward.steps import MissingField
from harness.reward.terms import needs_of
from harness.score.scorer import pay_log
from harness.score.weights import reweighted


def is_installed(registry: Registry, reward: str) -> bool:
    """Whether there is code for a reward of this name."""
    return "rewards" in registry.kinds_of(reward)


class InstalledReward:
    """A reward of the experiment, as it is installed now.

    Attributes:
        choice: The reward.
    """

    def __init__(self, choice: Choice, registry: Registry) -> None:
        self.choice, self._registry = choice, registry

    def fingerprint(self, taught_by: Choice) -> str:
        """What its pay of a run follows from beside the run: its parameters and sources, see `fingerprint`.

        Where it is not installed, the columns of the run itself tell what it pays, as far as they are of its own terms.

        Args:
            taught_by: The reward that paid the run when it was recorded.

        Raises:
            Unscored: There is no such reward any more.
        """
        with self._told():
            if self._is_recorded_by(taught_by):
                return f"{self.choice} as recorded by {taught_by}"
            return self._fingerprint

    @cached_property
    def _fingerprint(self) -> str:
        return f"{self.choice} {fingerprint(self._reward)}"

    @cached_property
    def has_terms(self) -> bool:
        """Whether what it pays is made of terms; False where it cannot be asked."""
        with suppress(Unscored), self._told():
            return bool(needs_of(self._reward).terms)
        return False

    def pay(self, run: Log, taught_by: Choice) -> Paid:
        """The shaped reward of every row of a run, and what each term of it paid, (rows,).

        Args:
            run: The run.
            taught_by: The reward that paid it when it was recorded.

        Raises:
            Unscored: It cannot, or what it pays cannot be counted with.
        """
        with self._told():
            return self.paid(run, taught_by)

    def pays_recorded(self, own: Log) -> bool:
        """Whether it pays what is recorded, except for last bits, in which another machine may differ.

        Args:
            own: What it paid itself, with the column ``reward``.

        Raises:
            Unscored: It cannot pay at all.
        """
        with self._told():
            return np.allclose(self.paid(own, self.choice).total, own["reward"], rtol=1e-9, atol=1e-12)

    def paid(self, run: Log, taught_by: Choice | None, begin: str = TERM) -> Paid:
        """The same; `begin` is how columns of the terms of who taught begin.

        Raises:
            HarnessError: What it pays cannot be counted with.
            Exception: Whatever the reward raises.
        """
        if self._is_recorded_by(taught_by) and (terms := terms_of(run, begin)):
            paid = reweighted(self.choice.label, taught_by, terms)
        else:
            paid = pay_log(self._reward, run)
        if not is_countable(paid.total).all():
            raise HarnessError(f"reward {self.choice.label} pays {UNCOUNTABLE}, on these runs")
        return paid

    def _is_recorded_by(self, taught_by: Choice | None) -> TypeGuard[Choice]:
        """Whether nothing but the columns of a run can tell what it pays, and these are of its own terms."""
        return taught_by is not None and taught_by.name == self.choice.name and not self._is_installed

    @cached_property
    def _is_installed(self) -> bool:
        return is_installed(self._registry, self.choice.name)

    @cached_property
    def _reward(self) -> Reward:
        if not self._is_installed:
            raise HarnessError(
                f"No reward '{self.choice.name}' is installed, and the run tells none of its terms: add --plugin FILE"
            )
        reward: Reward = self.choice.build(self._registry, "rewards")
        return reward

    @contextmanager
    def _told(self) -> Iterator[None]:
        """Turn any error of a reward into a reason, so that the rest can still be reported."""
        try:
            yield
        except SchemaError:  # of the run, whatever pays it
            raise
        except MissingField as error:
            told = f"reward {self.choice.label} reads {error.field}, which these trainings did not record"
            raise Unscored(f"{told}; new ones with it do") from error
        except HarnessError as error:  # one that is not installed any more
            raise Unscored(str(error)) from error
        except (Exception, SystemExit) as error:  # one that is, and cannot any more: a plugin may raise anything
            raise Unscored(f"reward {self.choice.label} could not score the runs: {one_line(error)}") from error
