"""What a task says of itself beside its members."""

from typing import ClassVar

import pytest

from harness.task import ReachTask, varies
from harness_plugins.tasks.unity import Arp2021, UnityReach


class Fixed(ReachTask):
    """It says that it does not vary."""

    varies: ClassVar[bool] = False


@pytest.mark.parametrize(
    ("task", "answer"), [(ReachTask(), True), (Fixed(), False), (UnityReach(), True), (Arp2021(), False)]
)
def test_task_varies_where_it_says_nothing(task, answer):
    """Only one that says so does not."""
    assert varies(task) is answer
