"""Has a plugin checked by another process, which may end, crash or never answer; each check comes to a finding."""

from collections.abc import Iterator
from dataclasses import dataclass, field

from harness.check.asked import Asked
from harness.check.finding import TARGET, Finding, PlannedCheck
from harness.check.workshop import Loss, Workshop, open_workshop
from harness.errors import UsageError

MOST_LOST, MOST_SILENT = 3, 2
"""After so many checks in a row in which the process ended, or did not answer in time, the rest is not run.

Those without an answer are fewer, since each takes all the time that it has.
"""


@dataclass
class Inspection:
    """The checks of one plugin, run one after the other.

    Attributes:
        asked: What is checked.
        long: Whether to run the checks that take minutes too.
        seconds: How long a check may take; None: as long as is usual for its kind.
        kind: ``rewards`` and so on, once the first finding is there; empty if the plugins could not be loaded.
    """

    asked: Asked
    long: bool = False
    seconds: float | None = None
    kind: str = field(default="", init=False)

    def findings(self) -> Iterator[Finding]:
        """Run the checks; each finding comes as soon as it is there.

        Raises:
            UsageError: The name is unknown, or its parameters cannot be.
        """
        with open_workshop(self.asked, self.seconds) as workshop:
            outline = workshop.open()
            if isinstance(outline, Loss):
                yield outline.finding(TARGET)
                return
            if outline.mistake:
                raise UsageError(outline.mistake)
            self.kind = outline.kind
            yield from outline.findings
            losses: list[Loss] = []
            for check in outline.checks:
                yield self._find(check, workshop, losses)

    def _find(self, check: PlannedCheck, workshop: Workshop, losses: list[Loss]) -> Finding:
        """Run a check unless there is a reason not to; keeps those that were lost in a row up to now in `losses`."""
        if check.long and not self.long:
            return Finding(check.name, "not run", "takes minutes: add --long")
        if reason := _why_no_more(losses):
            return Finding(check.name, "not run", reason)
        answer = workshop.run(check)
        if isinstance(answer, Loss):
            losses.append(answer)
            return answer.finding(check.name, check.fact)
        losses.clear()
        return answer


def _why_no_more(losses: list[Loss]) -> str:
    """Why no more checks are run after these were lost in a row; empty if there may be more."""
    if sum(loss.is_silent for loss in losses) >= MOST_SILENT:
        return f"{MOST_SILENT} checks in a row had no answer: mend that first"
    return f"{len(losses)} checks in a row ended the process: mend that first" if len(losses) >= MOST_LOST else ""
