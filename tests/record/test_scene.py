"""The arm in a cell's folder."""

import json

import numpy as np
import pytest

from harness.errors import SchemaError
from harness.record.scene import Body, Scene, SceneJoint, read_scene, write_scene

POINTS = np.array([[0.0, 0.0, 0.0], [0.5, 0.0, 0.0], [0.0, 0.25, 0.0], [0.0, 0.0, -0.1]])
FACES = np.array([[0, 2, 1], [0, 1, 3]], np.uint16)
SCENE_OF_ONE = Scene(
    "arm",
    (SceneJoint(np.eye(3, 4), np.array([0.0, 0.0, 1.0]), False),),
    np.eye(3, 4),
    (Body(0, "#ff8800", POINTS, FACES), Body(-1, "#202020", POINTS, FACES)),
)


def test_what_was_written_is_read(tmp_path):
    """Triangles, joints and colours come back; points to 1/32767 of the largest coordinate."""
    write_scene(SCENE_OF_ONE, tmp_path)
    found = read_scene(tmp_path)
    assert found is not None
    assert (found.robot, [body.joint for body in found.bodies]) == ("arm", [0, -1])
    assert found.bodies[0].colour == "#ff8800"
    np.testing.assert_array_equal(found.bodies[0].faces, FACES)
    np.testing.assert_allclose(found.bodies[0].points, POINTS, atol=0.5 / 32_767)
    np.testing.assert_array_equal(found.joints[0].frame, np.eye(3, 4))


def test_a_cell_of_an_earlier_version_has_none(tmp_path):
    """It is no error: such a cell is not shown."""
    assert read_scene(tmp_path) is None


def test_a_file_of_another_form_is_damaged(tmp_path_factory, subtests):
    """Nothing of a stranger's file is drawn before it was checked."""
    rows = [
        ({"format": 2}, "format"),
        ({"robot": 7}, "robot"),
        ({"joints": []}, "joints"),
        ({"tip": [2.0, 0, 0, 0, 0, 1.0, 0, 0, 0, 0, 1.0, 0]}, "no rotation"),
        ({"bodies": [{"joint": 3, "colour": "#ffffff", "scale": 1.0, "points": "", "faces": ""}]}, "body of joint 3"),
        ({"bodies": [{"joint": 0, "colour": "red", "scale": 1.0, "points": "", "faces": ""}]}, "colour"),
        ({"bodies": [{"joint": 0, "colour": "#ffffff", "scale": 1.0, "points": "", "faces": "AAAAAAAA"}]}, "corners"),
    ]
    for change, problem in rows:
        with subtests.test(change=change, problem=problem):
            tmp_path = tmp_path_factory.mktemp("case")
            (tmp_path / "scene.json").write_text(json.dumps({**SCENE_OF_ONE.to_json(), **change}))
            with pytest.raises(SchemaError, match=problem):
                read_scene(tmp_path)
