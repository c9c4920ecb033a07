import pytest


@pytest.fixture
def small_parts(monkeypatch):
    """Parts of seven steps."""
    for module in ("recorded_training", "recording_writer"):
        monkeypatch.setattr(f"harness.record.recording.{module}.PART_ROWS", 7)
