"""``recording-0.json`` and its parts: what `harness.RecordRewards` leaves of a training in any environment."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from harness.log import Log, in_memory
from harness.record.recording.facts import TrainingFacts
from harness.record.recording.recorded_training import is_recording, read_recording
from harness.record.recording.recording_writer import write_recording


@dataclass(frozen=True)
class Recording:
    """One training, or one evaluation, whose steps several rewards have scored."""

    takes_all = True

    def recognises(self, path: Path, head: bytes) -> bool:
        """A folder with the facts of recorder 0."""
        return is_recording(path)

    def read(self, path: Path) -> tuple[Log, ...]:
        """The one training of the folder; rows of several recorders in the order of time."""
        return (read_recording(path),)

    def write_example(self, folder: Path) -> Path:
        """Two episodes of three steps, paid by two rewards."""
        steps = np.arange(6)
        facts = TrainingFacts(rewards=("fast", "gentle"), trained_with="fast", behaviour=("success",), seed=0)
        columns = {
            "tick": steps,
            "env": np.zeros(6),
            "episode": steps // 3,
            "step": steps % 3,
            "reward/fast": steps / 2,
            "reward/gentle": -steps / 4,
            "behaviour/success": steps > 4,
            "terminated": steps % 3 == 2,
            "truncated": np.zeros(6),
        }
        write_recording(folder / "recording", in_memory(facts, columns))
        return folder / "recording"
