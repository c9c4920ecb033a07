"""The tracker `wandb`, for Weights & Biases."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field
from pydantic.dataclasses import dataclass

from harness.executor import Outcome, TrackedCell

if TYPE_CHECKING:
    import wandb

LONGEST = 128
"""Characters that the service allows for a name."""
STEPS = "steps"


@dataclass(frozen=True)
class WandB:
    """A run for each cell, grouped by combination.

    Runs are kept in ``wandb/`` of the working directory. They are also sent to the service, unless mode is offline. The
    library's own environment variables, such as WANDB_DIR and WANDB_BASE_URL, have effect.
    """

    project: Annotated[str, Field(min_length=1, description="project that the runs belong to")] = "fd100-harness"
    entity: Annotated[str, Field(description="user or team that owns the runs; empty: the library's default")] = ""
    mode: Annotated[
        Literal["online", "offline"],
        Field(description="'online' also sends the runs to the service; 'offline' keeps them here, for 'wandb sync'"),
    ] = "online"

    def why_not(self) -> str:
        import wandb

        if self.mode == "offline" or wandb.login(prompt=False, verify=False):
            return ""
        return "nobody is logged in here: type 'wandb login', or give mode=offline"

    def begin(self, cell: TrackedCell) -> "Run":
        import wandb

        # symlink=False: the harness writes nothing into an experiment's folder that holds links, and the working
        # directory may be such a folder.
        settings = wandb.Settings(silent=True, console="off", symlink=False, x_disable_stats=True)
        run = wandb.init(
            project=self.project,
            entity=self.entity or None,
            mode=self.mode,
            id=cell.id,
            resume="allow",
            reinit="create_new",
            name=cell.title[:LONGEST],
            group=cell.group[:LONGEST],
            config=dict(cell.config),
            settings=settings,
        )
        run.define_metric("*", step_metric=STEPS)
        return Run(run)


class Run:
    """The run of one cell."""

    def __init__(self, run: "wandb.Run") -> None:
        self._run = run

    def log(self, steps: int, scalars: Mapping[str, float]) -> None:
        self._run.log({STEPS: steps, **scalars})

    def end(self, outcome: Outcome, reason: str) -> None:
        self._run.summary.update({"outcome": outcome, "reason": reason})
        self._run.finish(exit_code=0 if outcome == "done" else 1)
