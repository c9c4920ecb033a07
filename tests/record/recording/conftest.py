import pytest


@pytest.fixture
def small_parts(monkeypatch):
    """Parts of seven steps."""
    for module in ("parts", "recording.recorded_training"):
        monkeypatch.setattr(f"harness.record.{module}.PART_ROWS", 7)
