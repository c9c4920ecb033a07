"""Simulators that are wrong in one known way, on top of the ideal one."""

import io
from dataclasses import dataclass

import numpy as np
import pytest
from rich.console import Console

from harness import load_robot
from harness.env.ideal import IdealSimulation
from harness_plugins.kit import IdealSimulator
from harness_plugins.parity import Setting, compare_simulators, parity_table
from harness_plugins.parity.contenders import Contenders
from tests.registered import FD100


@dataclass(frozen=True)
class Wrong:
    """Opens a simulation of its own."""

    simulation: type
    options: tuple = ()

    def open(self, robot, num_envs, control_period):
        """Start."""
        return self.simulation(robot, num_envs, *self.options)


class ShiftedTip(IdealSimulation):
    """The tip is `by` metres too high."""

    def __init__(self, robot, num_envs, by):
        super().__init__(robot, num_envs)
        self.by = by

    def state(self):
        """With the tip elsewhere."""
        state = super().state()
        state.end_effector[:, 2] += self.by
        return state


class Late(IdealSimulation):
    """The arm arrives a period later than it should."""

    def reset(self, qpos, mask):
        """Nothing is pending."""
        self.pending = qpos.copy()
        return super().reset(qpos, mask)

    def drive(self, qpos, duration):
        """Go where it was to go before."""
        before, self.pending = self.pending, qpos.copy()
        return super().drive(before, duration)


class Numb(IdealSimulation):
    """Sees no contact."""

    def state(self):
        """In the air."""
        state = super().state()
        return state._replace(ground_contact=np.zeros_like(state.ground_contact))


class Shy(IdealSimulation):
    """Sees contact where there is none yet: whenever its tip is below `height` metres."""

    def __init__(self, robot, num_envs, height):
        super().__init__(robot, num_envs)
        self.height = height

    def state(self):
        """Touching early."""
        state = super().state()
        return state._replace(ground_contact=state.ground_contact | (state.end_effector[:, 2] < self.height))


class Reusing(IdealSimulation):
    """Writes over the arrays that it returned before."""

    held = None

    def state(self):
        """In the same arrays as ever."""
        state = super().state()
        self.held = self.held or state._replace(**{name: it.copy() for name, it in state._asdict().items()})
        for kept, new in zip(self.held, state, strict=True):
            kept[...] = new
        return self.held


class Misplaced(IdealSimulation):
    """Joints are put 0.01 rad off; the tip is where these joints have it."""

    def place(self, qpos):
        """Put elsewhere."""
        return super().place(qpos + 0.01)


class Raising(IdealSimulation):
    """One of its calls raises; `envs` says for which number of arms, 0 for any."""

    def __init__(self, robot, num_envs, call, envs):
        super().__init__(robot, num_envs)
        if envs in (0, num_envs):
            setattr(self, call, self.fail)

    def fail(self, *arguments):
        """Raise."""
        raise RuntimeError("the belt\n  slipped")


class Exploding(IdealSimulation):
    """Leaves the finite numbers after some periods."""

    periods = 0

    def drive(self, qpos, duration):
        """Explode at the third."""
        self.periods += 1
        return super().drive(np.full_like(qpos, np.nan) if self.periods == 3 else qpos, duration)


@dataclass(frozen=True)
class Closed:
    """Cannot be opened."""

    error: type = MemoryError

    def open(self, robot, num_envs, control_period):
        """Raise."""
        raise self.error


@pytest.fixture(scope="session")
def toolbox():
    """Makers of wrong simulators, each of the ideal one but for one fault."""

    class Toolbox:
        ideal, closed, interrupted = IdealSimulator(), Closed(), Closed(KeyboardInterrupt)
        late, reusing, numb, misplaced, exploding = map(Wrong, (Late, Reusing, Numb, Misplaced, Exploding))

        @staticmethod
        def shifted_tip(by):
            return Wrong(ShiftedTip, (by,))

        @staticmethod
        def shy(height):
            return Wrong(Shy, (height,))

        @staticmethod
        def raising(call, envs=0):
            return Wrong(Raising, (call, envs))

    return Toolbox


@pytest.fixture(scope="session")
def printed():
    """What goes to a terminal, of a width where no line is broken unless another is given."""

    def show(parity, width=4_000):
        console = Console(width=width, file=io.StringIO())
        console.print(parity_table(parity))
        return console.file.getvalue()

    return show


@pytest.fixture(scope="session")
def robot():
    """The FD100."""
    return FD100


@pytest.fixture(scope="session", params=["fd100", "unity-arm"])
def each_robot(request):
    """Both robots, one after the other."""
    return load_robot(request.param)


@pytest.fixture(scope="session")
def compare(robot):
    """Compare simulators, given by name, the reference first."""

    def call(missing=(), arm=robot, steps=40, episodes=3, **simulators):
        return compare_simulators(Contenders(simulators, tuple(missing)), Setting(arm, steps, episodes))

    return call
