"""An arm with every kind of joint and of shape."""

import pytest

from harness.robot import parse_urdf
from harness.robot.shapes import attach_shapes, read_shapes

ARM = """
<robot name="arm">
  <link name="base"><collision><geometry><sphere radius="9"/></geometry></collision></link>
  <link name="foot"><collision><geometry><sphere radius="8"/></geometry></collision></link>
  <link name="upper">
    <collision>
      <origin xyz="0.1 0.2 0.3" rpy="0.4 0.5 0.6"/> <geometry><box size="0.1 0.2 0.3"/></geometry>
    </collision>
    <collision><geometry><cylinder radius="0.05" length="0.4"/></geometry></collision>
  </link>
  <link name="slider">
    <collision><origin rpy="1 0 0"/><geometry><capsule radius="0.04" length="0.2"/></geometry></collision>
  </link>
  <link name="bracket"/> <link name="flange"/>
  <link name="tip"><collision><origin xyz="0 0.1 0"/><geometry><sphere radius="0.07"/></geometry></collision></link>
  <link name="finger"><collision><geometry><sphere radius="7"/></geometry></collision></link>
  <joint name="bolt" type="fixed"> <parent link="base"/> <child link="foot"/> </joint>
  <joint name="turn" type="continuous">
    <parent link="foot"/> <child link="upper"/> <origin xyz="0.1 -0.2 0.3" rpy="0.4 0.5 0.6"/> <axis xyz="0 3 4"/>
  </joint>
  <joint name="slide" type="prismatic">
    <parent link="upper"/> <child link="slider"/>
    <origin xyz="0 0 0.5" rpy="0 1.5707963267948966 0"/> <axis xyz="1 2 0"/> <limit lower="0" upper="0.25"/>
  </joint>
  <joint name="spin" type="revolute">
    <parent link="slider"/> <child link="bracket"/> <axis xyz="0 0 -1"/> <limit lower="-2" upper="2"/>
  </joint>
  <joint name="mount" type="fixed">
    <parent link="bracket"/> <child link="flange"/> <origin xyz="1 0 0" rpy="0 0 1.5707963267948966"/>
  </joint>
  <joint name="weld" type="fixed"> <parent link="flange"/> <child link="tip"/> <origin xyz="0 0.2 0"/> </joint>
  <joint name="grip" type="prismatic">
    <parent link="tip"/> <child link="finger"/> <limit lower="0" upper="0.1"/>
  </joint>
</robot>
"""


@pytest.fixture(scope="session")
def arm_text():
    """The URDF of an arm of three joints, with links and shapes beside the chain."""
    return ARM


@pytest.fixture(scope="session")
def attached():
    """The shapes that each of its three joints moves."""
    urdf = parse_urdf(ARM)
    return attach_shapes(urdf, read_shapes(urdf), ("turn", "slide", "spin"))
