"""The state of a MuJoCo model."""

import mujoco
import pytest


@pytest.fixture
def data(model):
    """The state of the module's `model`, at the zero pose."""
    return mujoco.MjData(model)
