"""An error of the user: one line that says what was given and what to do."""

from contextlib import contextmanager

import pytest

from harness.errors import UsageError


@contextmanager
def refused(told):
    """A usage error of one line, which matches this pattern."""
    with pytest.raises(UsageError, match=told) as caught:
        yield caught
    assert "\n" not in str(caught.value)
