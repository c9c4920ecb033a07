"""Probes: where one solid alone is in the ground, a simulator that has it touches, and one that lacks it does not."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from harness.env.ideal import IdealSimulation
from harness.env.solid_probes import DEPTH, GAP, find_missing, missing_in_words, probes_of, require_solids
from harness.errors import MissingSolid
from harness.robot import Robot, build_solids, link_frames
from harness_plugins.kit import IdealSimulator
from tests.registered import FD100 as ROBOT

PROBES = probes_of(ROBOT)


class TouchesWith(IdealSimulation):
    """Touches the ground with some solids only."""

    def __init__(self, robot: Robot, num_envs: int, first: int) -> None:
        super().__init__(robot, num_envs)
        self.solids = build_solids([group if joint < first else () for joint, group in enumerate(robot.joint_shapes)])

    def state(self):
        """With the contact of these."""
        contact = self.solids.touch_ground(link_frames(self.robot.chain, self.qpos))
        return super().state()._replace(ground_contact=contact)


@dataclass(frozen=True)
class Without:
    """A simulator that has the solids of the first joints only."""

    first: int

    def open(self, robot, num_envs, control_period):
        """Start."""
        return TouchesWith(robot, num_envs, self.first)


def test_at_a_probe_one_solid_alone_is_in_the_ground():
    """That deep, and all others above it, by the harness's own solids one by one."""
    assert {probe.link for probe in PROBES} >= {"tool0", "link4"}
    for probe in PROBES:
        frames = link_frames(ROBOT.chain, probe.qpos[None])
        alone = [build_solids([(shape,) if joint == number else () for number in range(ROBOT.dof)])
                 for joint, group in enumerate(ROBOT.joint_shapes) for shape in group]  # fmt: skip
        heights = np.sort([float(solid.lowest(frames)[0]) for solid in alone])
        assert heights[0] <= -0.8 * DEPTH
        assert heights[1] >= GAP


def test_the_same_robot_has_the_same_probes():
    """So a run and a check look at the same."""
    for one, other in zip(PROBES, probes_of(ROBOT), strict=True):
        assert_array_equal(one.qpos, other.qpos)


def test_a_simulator_with_all_solids_passes():
    """Nothing is raised, for one arm as for several."""
    require_solids("ideal", IdealSimulator(), ROBOT)
    assert find_missing(IdealSimulation(ROBOT, 3), PROBES, 3) == ()


def test_a_simulator_that_lacks_a_solid_is_named_with_the_link():
    """It has all solids but those of the last joint."""
    with pytest.raises(MissingSolid, match=r"Simulator 'torn' has no solid for link 'tool0' \(cylinder\)"):
        require_solids("torn", Without(ROBOT.dof - 1), ROBOT)


def test_a_simulator_without_contact_is_no_fault_of_the_arm():
    """It touches the ground with no arm: the check of simulators says so, and runs with toys go on."""
    require_solids("numb", Without(0), ROBOT)


def test_an_arm_of_one_solid_that_is_dropped_is_told():
    """The simulator touches nothing with it, but does with another arm."""

    @dataclass(frozen=True)
    class DropsMeshes:
        def open(self, robot, num_envs, control_period):
            return TouchesWith(robot, num_envs, robot.dof if robot.name == ROBOT.name else 0)

    shapes = (*[()] * (ROBOT.dof - 1), ROBOT.joint_shapes[-1])
    alone = {link: group if link == "tool0" else () for link, group in ROBOT.link_shapes.items()}
    with pytest.raises(MissingSolid, match="of robot 'rod'"):
        require_solids("torn", DropsMeshes(), replace(ROBOT, name="rod", joint_shapes=shapes, link_shapes=alone))


def test_an_arm_that_never_reaches_the_ground_has_no_probes():
    """And none without solids: nothing can be told of these."""
    assert probes_of(replace(ROBOT, lower=ROBOT.home - 0.05, upper=ROBOT.home + 0.05)) == ()
    assert probes_of(replace(ROBOT, link_shapes=dict.fromkeys(ROBOT.link_shapes, ()))) == ()


def test_several_links_are_named_once_each():
    """In the order of the links."""
    assert missing_in_words([*PROBES, *PROBES]).startswith("no solid for links 'link4' (cylinder), ")
