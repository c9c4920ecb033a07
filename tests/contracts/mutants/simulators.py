"""Broken simulators: a simulation that is ideal but for one thing."""

import time
from dataclasses import replace

import numpy as np

from harness.robot import build_solids, link_frames
from harness.simulator import State
from harness_plugins.kit import IdealSimulator
from harness_plugins.kit.simulators.simulations import PERIOD
from tests.registered import FD100 as ROBOT, REGISTRY

from . import mutant

Mujoco = REGISTRY.get("simulators", "mujoco").load()
Ideal = type(IdealSimulator().open(ROBOT, 1, PERIOD))
SOLIDS = build_solids([*ROBOT.joint_shapes[:-1], ROBOT.joint_shapes[-1][:-1]])


def opens(**changed):
    """A simulator whose simulations have other methods or attributes."""
    return mutant(
        IdealSimulator,
        open=lambda self, robot, num_envs, period: type("Simulation", (Ideal,), changed)(robot, num_envs),
    )


def tells(**told):
    """A simulator that tells other states: each field is made of the state as it is."""

    def state(sim):
        state = Ideal.state(sim)
        return state._replace(**{name: make(state) for name, make in told.items()})

    return opens(state=state)


def goes(target, **changed):
    """A simulator that drives to other places."""
    return opens(drive=lambda sim, qpos, duration: Ideal.drive(sim, target(sim, qpos, duration), duration), **changed)


def frame(target, width, height):
    """A frame of one colour, which depends on where the target is."""
    return np.full((height, width, 3), target.sum() * 50.0).astype(np.uint8)


def renders(render=frame):
    """A simulator that renders."""
    return opens(render=lambda sim, env, target, width, height: render(target, width, height))


def fast(sim, qpos):
    """Placing leaves a speed behind."""
    Ideal.place(sim, qpos)
    sim.qvel += 0.1
    return sim.state()


def kept(sim, qpos):
    """What it is placed at stays the caller's array."""
    state = Ideal.place(sim, qpos)
    sim.qpos = qpos
    return state


def stays(sim):
    """A contact is never forgotten."""
    state = Ideal.state(sim)
    sim.touched = sim.touched | state.ground_contact
    return state._replace(ground_contact=sim.touched)


def worn(sim, qpos, _):
    """A little is left over from every drive."""
    sim.drives += 1
    return qpos + 1e-12 * sim.drives


def of_one_size(sim, env, target, width, height):
    """The renderer is made once, of the size of the first frame."""
    sim.size = sim.size or (width, height)
    return frame(target, *sim.size)


def moved(sim, env, target, width, height):
    """Rendering steps the engine."""
    sim.qvel += 1e-3
    return frame(target, width, height)


def no_library(*_):
    """Rendering needs one that is not there."""
    raise ImportError("no GL")


def close(sim):
    """The engine is released a second time."""
    if sim.closed:
        raise RuntimeError("there is no engine")
    sim.closed = True


def counted(sim, qpos, mask):
    """How often others were reset on their own."""
    sim.count = 0 if mask.all() else sim.count + 1
    return Ideal.reset(sim, qpos, mask)


def begun(sim, qpos, mask):
    """The periods of an episode."""
    sim.periods = 0
    return Ideal.reset(sim, qpos, mask)


def diverges(sim, qpos, duration):
    """What it adds up overflows at the 37th."""
    sim.periods += 1
    state = Ideal.drive(sim, qpos, duration)
    return state._replace(qvel=np.full_like(state.qvel, np.nan)) if sim.periods >= 37 else state


def without_tool(state):
    """The engine could not read the shape of the tool, and went on without it."""
    return SOLIDS.touch_ground(link_frames(ROBOT.chain, state.qpos)) | (ROBOT.end_effector(state.qpos)[:, 2] < -0.05)


class Lagging(Ideal):
    """The end effector is where it was before the drive."""

    before = None

    def reset(self, qpos, mask):
        self.before = self.qpos.copy() if self.before is None else self.before
        self.before[mask] = qpos[mask]
        return super().reset(qpos, mask)

    def drive(self, qpos, duration):
        self.before = self.qpos.copy()
        return super().drive(qpos, duration)

    def state(self):
        at = self.qpos if self.before is None else self.before
        return super().state()._replace(end_effector=self.robot.end_effector(at))


def misreads(change):
    """A simulator that takes other drives than the robot's."""

    def open_other(self, robot, num_envs, period):
        return Mujoco.open(self, replace(robot, servo=change(robot.servo)), num_envs, period)

    return mutant(Mujoco, open=open_other)


def spoils(spoil):
    """A simulator of which something is spoiled after it was opened with the robot's drives."""

    def open_spoiled(self, robot, num_envs, period):
        simulation = Mujoco.open(self, robot, num_envs, period)
        if self.drive == "servo":
            spoil(simulation, self.substeps)
        return simulation

    return mutant(Mujoco, open=open_spoiled)


def forgets_a_period(simulation, substeps):
    """A reset forgets as many commands as a control period has, of those that are still to come."""
    track = simulation._feed._track
    reset = track.reset

    def forget(qpos, mask):
        later = track._coming[substeps:].copy()
        reset(qpos, mask)
        track._coming[substeps:] = later

    track.reset = forget


def touches_nothing(simulation, _):
    """The model has lost its sensor."""
    read = simulation._arms.read
    simulation._arms.read = lambda: (state := read())._replace(ground_contact=np.zeros_like(state.ground_contact))


LEAKED = []
SOUND = (renders(),)
MUTANTS = {
    "an axis too many": ("sim-shapes", tells(ground_contact=lambda s: s.ground_contact[:, None])),
    "single precision": ("sim-dtypes", tells(qvel=lambda s: s.qvel.astype(np.float32))),
    "breaks on the ground": ("sim-finite", tells(qvel=lambda s: np.where(s.ground_contact[:, None], np.nan, s.qvel))),
    "diverges in time": ("sim-finite", opens(periods=0, reset=begun, drive=diverges)),
    "resets roughly": ("sim-reset", opens(reset=lambda sim, qpos, mask: Ideal.reset(sim, qpos.round(3), mask))),
    "places in motion": ("sim-place", opens(place=fast)),
    "ignores the mask": ("sim-reset-mask", opens(reset=lambda sim, qpos, mask: Ideal.reset(sim, qpos, mask | True))),
    "envs in reverse": ("sim-reset-mask", opens(state=lambda sim: State._make(it[::-1] for it in Ideal.state(sim)))),
    "lags with the end effector": (
        "sim-end-effector",
        mutant(IdealSimulator, open=lambda self, robot, num_envs, period: Lagging(robot, num_envs)),
    ),
    "beside the tip": ("sim-end-effector", tells(end_effector=lambda s: s.end_effector + 1e-4)),
    "joints in another order": (
        "sim-end-effector",
        tells(end_effector=lambda s: ROBOT.end_effector(s.qpos[:, ::-1])),
    ),
    "drives softly": ("sim-tracking", goes(lambda sim, qpos, _: sim.qpos + 0.95 * (qpos - sim.qpos))),
    "degrees": ("sim-velocity", tells(qvel=lambda s: np.degrees(s.qvel))),
    "sticks": (
        "sim-small-moves",
        goes(lambda sim, qpos, _: np.where(np.abs(qpos - sim.qpos) < np.radians(0.4), sim.qpos, qpos)),
    ),
    "stands still": ("sim-small-moves", opens(drive=lambda sim, qpos, duration: sim.state())),
    "knows one period": (
        "sim-partial-durations",
        opens(drive=lambda sim, qpos, duration: Ideal.drive(sim, qpos, PERIOD)),
        "the speed",
    ),
    "goes a share of the way": (
        "sim-partial-durations",
        goes(lambda sim, qpos, t: sim.qpos + t / PERIOD * (qpos - sim.qpos)),
        "-0.0295",
    ),
    "lasts a whole period": (
        "sim-partial-durations",
        goes(lambda sim, qpos, t: sim.qpos + PERIOD / t * (qpos - sim.qpos)),
        "-0.118",
    ),
    "owes the rest": (
        "sim-partial-durations",
        goes(lambda sim, qpos, t: sim.qpos + np.floor(3 * t / PERIOD + 1e-9) / (3 * t / PERIOD) * (qpos - sim.qpos)),
        "-0.0393",
    ),
    "never touches": ("sim-ground-contact", tells(ground_contact=lambda s: s.ground_contact & False)),
    "always touches": ("sim-no-false-contact", tells(ground_contact=lambda s: s.ground_contact | True)),
    "drops a solid": ("sim-solids", tells(ground_contact=without_tool), "no solid for link 'tool0' (cylinder)"),
    "touches together": (
        "sim-contact-per-env",
        tells(ground_contact=lambda s: s.ground_contact | s.ground_contact.any()),
    ),
    "touches elsewhere": ("sim-contact-per-env", tells(ground_contact=lambda s: np.roll(s.ground_contact, 1))),
    "reads the opening": ("sim-read", opens(read=lambda sim: Ideal(sim.robot, len(sim.qpos)).state())),
    "keeps the array": ("sim-arguments", opens(place=kept), "is part of the state"),
    "writes into the array": ("sim-arguments", goes(lambda sim, qpos, _: qpos.__isub__(1e-12)), "array was changed"),
    "tells what it was told": (
        "sim-state-owned",
        opens(drive=lambda sim, qpos, duration: Ideal.drive(sim, qpos, duration)._replace(qpos=qpos)),
    ),
    "shakes on the ground": (
        "sim-determinism",
        tells(
            qvel=lambda s: (
                s.qvel + s.ground_contact[:, None] * np.random.default_rng().uniform(-1e-9, 1e-9, s.qvel.shape)
            )
        ),
    ),
    "stays on the ground": ("sim-reset-forgets", opens(state=stays, touched=False)),
    "wears out": ("sim-reset-forgets", goes(worn, drives=0)),
    "counts its resets": (
        "sim-resume",
        goes(lambda sim, qpos, _: qpos + 1e-12 * sim.count, count=0, reset=counted),
        "raised SchemaError: the simulator does not repeat itself",
    ),
    "counts its envs": ("sim-batch-as-alone", goes(lambda sim, qpos, _: qpos + 1e-12 * len(qpos)), "env 0 of 3"),
    "prefers the first": (
        "sim-batch-as-alone",
        goes(lambda sim, qpos, _: qpos + 1e-12 * np.arange(len(qpos))[:, None]),
        "env 1 of 3",
    ),
    "pushes its neighbour": (
        "sim-env-isolation",
        goes(lambda sim, qpos, _: qpos + 1e-9 * (qpos - np.roll(qpos, 1, axis=0))),
    ),
    "one arm for all": (
        "sim-env-isolation",
        opens(state=lambda sim: State._make(np.repeat(it[:1], len(it), axis=0) for it in Ideal.state(sim))),
    ),
    "reverses the batch": ("sim-batch-order", goes(lambda sim, qpos, _: qpos[::-1]), "goes by 0.022"),
    "reverses the speeds": ("sim-batch-order", tells(qvel=lambda s: s.qvel[::-1]), "has the speed 0.22"),
    "sleeps on": (
        "sim-rest",
        goes(
            lambda sim, qpos, _: np.where(sim.asleep[:, None], sim.qpos, qpos),
            asleep=np.zeros(1, bool),
            rest=lambda sim, mask: setattr(sim, "asleep", mask.copy()),
        ),
    ),
    "frames sideways": (
        "sim-render",
        renders(lambda target, width, height: frame(target, height, width)),
        "(64, 48, 3)",
    ),
    "frames in floats": ("sim-render", renders(lambda *at: frame(*at) / 255.0), "float64"),
    "frames of the first size": ("sim-render", opens(render=of_one_size, size=None), "80 x 60"),
    "moves to render": ("sim-render", opens(render=moved), "changed the state"),
    "has no renderer": ("sim-render", renders(no_library), "raised ImportError: no GL"),
    "hides the target": ("sim-render-target", renders(lambda target, *size: frame(np.zeros(3), *size))),
    "renders nothing": ("sim-render-tried", IdealSimulator()),
    "closes once": ("sim-close", opens(close=close, closed=False), "raised RuntimeError: there is no engine"),
    "lacks read": ("sim-methods", opens(read=None), "has no method read()"),
    "names its arguments": (
        "sim-methods",
        opens(render=lambda sim, number, marker, width, height: None),
        "render(number, marker,",
    ),
    "keeps every state": (
        "sim-leak",
        opens(kept=LEAKED, drive=lambda sim, *to: sim.kept.append(Ideal.drive(sim, *to)) or sim.state()),
    ),
    "leaks": (
        "sim-long-run",
        goes(lambda sim, qpos, _: LEAKED.append(np.ones(40_000)) or qpos),
        "the process grew by",
    ),
    "drifts": (
        "sim-long-run",
        goes(lambda sim, qpos, _: qpos + 1e-9 * (worn(sim, 0.0, _) > 1000e-12), drives=0),
        "the same episode goes another way, by up to 1e-09",
    ),
    "slow": (
        "sim-slow",
        goes(lambda sim, qpos, _: time.sleep(0.008) or qpos),
        " ms: training for 100,000 steps takes ",
    ),
    "drives of twice the strength": (
        "sim-servo-limits",
        misreads(lambda servo: replace(servo, max_torque=2.0 * servo.max_torque)),
    ),
    "drives of one strength": (
        "sim-servo-strength",
        misreads(lambda it: replace(it, max_torque=np.minimum(it.max_torque, 0.4 * ROBOT.servo.max_torque))),
    ),
    "drives without latency": ("sim-servo-latency", misreads(lambda servo: replace(servo, latency=0.0))),
    "drives without friction": (
        "sim-servo-friction",
        misreads(
            lambda it: replace(it, viscous_friction=0.0 * it.viscous_friction, dry_friction=0.0 * it.dry_friction)
        ),
    ),
    "motors of the robot's inertia": (
        "sim-servo-armature",
        misreads(lambda servo: replace(servo, armature=ROBOT.servo.armature)),
    ),
    "a reset forgets a period": ("sim-servo-forgets", spoils(forgets_a_period)),
    "touches nothing with drives": (
        "sim-servo",
        spoils(touches_nothing),
        "with drive=servo, sim-ground-contact: the arm was driven into the ground",
    ),
}
