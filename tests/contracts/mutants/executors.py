"""Broken executors."""

from dataclasses import dataclass

from harness.executor import Event, run_job

from . import mutant


@dataclass(frozen=True)
class Sound:
    """One cell after the other, in this process."""

    def run(self, jobs, at_once, on_event):
        for job in jobs:
            on_event(Event("started", job.cell))
            run_job(job)
            on_event(Event("ended", job.cell))


def pretend(self, jobs, at_once, on_event):
    """Says that cells are done, and does none."""
    for job in jobs:
        on_event(Event("started", job.cell))
        on_event(Event("ended", job.cell))


def mute(self, jobs, at_once, on_event):
    """Does them all and tells nobody."""
    Sound().run(jobs, at_once, lambda event: None)


def pessimist(self, jobs, at_once, on_event):
    """Ends what is done with a reason."""
    Sound().run(jobs, at_once, lambda event: on_event(event._replace(reason="lost" * (event.kind == "ended"))))


MUTANTS = {
    "does nothing": ("executor-cells", mutant(Sound, run=pretend), "left no folder"),
    "tells nothing": ("executor-cells", mutant(Sound, run=mute), "told [] of a cell"),
    "blames the sound": ("executor-cells", mutant(Sound, run=pessimist), "ended with 'lost'"),
}
SOUND = (Sound(),)
