"""How policies acted, and when: one word for each, in files, flags, tables and reports."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final, Literal, TypeAlias, get_args

Manner: TypeAlias = Literal["deterministic", "stochastic"]
Acted: TypeAlias = Literal["", "deterministic", "stochastic", "random"]
"""How the policy of an evaluation chose its actions: the best one, drawn, or without a policy; empty: nobody told."""
ACTED: tuple[Acted, ...] = get_args(Acted)
DETERMINISTIC: Final = "deterministic"
STOCHASTIC: Final = "stochastic"
ACTED_AT_RANDOM: Final = "random"
EVALUATION = "in evaluations"
"""The evaluations of recorded trainings."""
LAST, LEARNING = "in the last evaluations", "while learning"
"""The mean over the last evaluations, see `harness.results.metrics.last_values`; and all of them in order."""
TRAINING, WHOLE, LAST_FIFTH = "while training", "over the training", "in its last fifth"
"""The episodes of a training itself: of an arm's, of a recorded one, and of the end of a recorded one."""
MANNERS = (EVALUATION, *(f"{EVALUATION}, {acted}" for acted in (DETERMINISTIC, STOCHASTIC)), LAST_FIFTH, WHOLE)
"""Those of a recorded training. What says most about the final policies comes first. Evaluations in the other manner
say how their policies acted."""
OWN_AND_OTHER: Mapping[bool, tuple[Manner, Manner]] = MappingProxyType(
    {True: (DETERMINISTIC, STOCHASTIC), False: (STOCHASTIC, DETERMINISTIC)}
)
"""How the policies of a cell act in its evaluations, and in those in the other manner; by whether it is to be
deterministically."""
