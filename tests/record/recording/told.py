"""Columns of a recorded training by the names of its terms and measures, and one of its numbers that is changed."""

import pyarrow as pa
import pyarrow.parquet as pq


def terms_of(log, reward):
    """What each term of a reward paid, (steps,) each, in their order."""
    return {name: log[f"reward/{reward}/{name}"] for name in log.terms_of(reward)}


def change_first(path, name, value):
    """Give the first row of a part another value."""
    table = pq.read_table(path)
    values = table.column(name).to_numpy().copy()
    values[0] = value
    table = table.set_column(table.schema.get_field_index(name), table.schema.field(name), pa.array(values))
    pq.write_table(table, path)
