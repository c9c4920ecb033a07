"""What a run tells of its running cells."""

import pytest

from harness.errors import SchemaError
from harness.record.cell import Running, read_running, write_running


def test_what_is_written_is_read(tmp_path):
    """Cell by cell."""
    running = {"a": Running(100.0).after(40, 101.5), "b": Running(102.0)}
    write_running(tmp_path, running)
    assert read_running(tmp_path) == running


def test_steps_do_not_go_back():
    """A cell that starts over tells fewer steps than before, and the clock of its last word goes on."""
    assert Running(0.0).after(40, 1.0).after(10, 2.0) == Running(0.0, 40, 2.0)


def test_nothing_is_running_where_nothing_is_written(tmp_path):
    """Before a run, and after it."""
    assert read_running(tmp_path) == {}


@pytest.mark.parametrize("content", ["", "[]", '{"a": 3}', '{"a": {"started": -1}}', '{"a": {"started": NaN}}'])
def test_a_damaged_account_is_named(tmp_path, content):
    """It may come from anybody."""
    (tmp_path / "running.json").write_text(content)
    with pytest.raises(SchemaError, match="is no readable account of running cells"):
        read_running(tmp_path)
