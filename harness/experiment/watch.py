"""The interface of what looks on while a cell is run."""

from typing import TYPE_CHECKING, Literal, TypeAlias

if TYPE_CHECKING:
    from harness.env import ReachVectorEnv

Stage: TypeAlias = Literal["trace", "evaluation", "saving"]
"""What a cell goes through behind its training: the trace is finished; the policy evaluated; the rest saved."""


class Watch:
    """Told where a cell is. This one does nothing with it: each method may be replaced. None may change a result."""

    def follow(self, env: "ReachVectorEnv") -> None:
        """`env` is ready, its recorder included: the training begins."""

    def enter(self, stage: Stage) -> None:
        """What follows belongs to `stage`."""


UNWATCHED = Watch()
