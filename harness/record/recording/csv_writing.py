"""A recorded training as a CSV file."""

from pathlib import Path

import pyarrow as pa
import pyarrow.csv

from harness.files.whole_file import whole_file
from harness.record.recording.facts import facts_of, file_column
from harness.record.recording.recorded_training import FLAGS, INTEGERS, TICK, TICK_IN_FILE, read_recording


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
    log = read_recording(folder)
    facts = facts_of(log)
    names = (TICK, *INTEGERS, *facts.numbers, *FLAGS, *facts.term_columns)
    rows = log.rows(names)
    columns = {
        TICK_IN_FILE if name == TICK else name if name in facts.term_columns else file_column(name): rows[name]
        for name in names
    }
    table = pa.table({name: pa.array(values, from_pandas=True) for name, values in columns.items()})
    with whole_file(path) as partial:
        pa.csv.write_csv(table, partial, pa.csv.WriteOptions(quoting_style="needed"))
