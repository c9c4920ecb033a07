"""A recorded training as a CSV file."""

from pathlib import Path

import pyarrow as pa
import pyarrow.csv

from harness.files.whole_file import whole_file
from harness.record.recording.facts import BEHAVIOUR, REWARD, term_column
from harness.record.recording.recorded_training import FLAGS, INTEGERS, read_recording


def write_recording_csv(folder: Path, path: Path) -> None:
    """Write a recording to `path`, whole or not at all: one row for each step, in the order of time.

    The columns are ``time``, ``env``, ``episode``, ``step``, then ``reward_<name>`` and ``behaviour_<name>`` for every
    reward and measure, ``terminated`` and ``truncated``, and ``reward/<name>/<term>`` for each term of a reward. A
    number has as many digits as it takes to read it back exactly. Where a reward or a measure has no value, the field
    is empty.

    Args:
        folder: Of the recording.
        path: A CSV file, in a folder that is there.

    Raises:
        SchemaError: The recording is damaged or written by a newer version.
        OSError: `path` cannot be written.
    """
    recording = read_recording(folder)
    columns = {name: getattr(recording, name) for name in ("time", *INTEGERS)}
    columns |= {f"{REWARD}{name}": values for name, values in recording.rewards.items()}
    columns |= {f"{BEHAVIOUR}{name}": values for name, values in recording.behaviour.items()}
    columns |= {name: getattr(recording, name) for name in FLAGS}
    columns |= {term_column(name, term): it for name, of in recording.terms.items() for term, it in of.items()}
    table = pa.table({name: pa.array(values, from_pandas=True) for name, values in columns.items()})
    with whole_file(path) as partial:
        pa.csv.write_csv(table, partial, pa.csv.WriteOptions(quoting_style="needed"))
