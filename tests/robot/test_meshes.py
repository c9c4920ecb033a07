"""Finding mesh files, and reading STL and OBJ."""

import os
import re
import struct
import sys
from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis.extra.numpy import arrays
from hypothesis.strategies import integers, sampled_from
from numpy.testing import assert_allclose, assert_array_equal

from harness.errors import UsageError
from harness.robot import read_mesh
from harness.robot.meshes import distinct, locate_mesh, needs_extra
from tests.refusals import refused

CORNERS = np.array([[[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 0, 0], [0, 0, 1], [1, 0, 0]]], dtype=np.float32)
"""Of two triangles with an edge in common."""
NONE = "cannot be read as a mesh"
POINTS = np.unique(CORNERS.reshape(-1, 3), axis=0)


def binary_stl(corners, header=b""):
    """An STL file of triangles, (count, 3, 3)."""
    triangles = b"".join(struct.pack("<12fH", 0, 0, 0, *triangle.ravel(), 0) for triangle in corners)
    return header.ljust(80) + struct.pack("<I", len(corners)) + triangles


def text_stl(corners):
    """The same as text."""
    facets = "".join(
        "facet normal 0 0 0\n outer loop\n"
        + "".join("  vertex {} {:e} {}\n".format(*corner) for corner in triangle)
        + " endloop\nendfacet\n"
        for triangle in corners
    )
    return f"solid part\n{facets}endsolid part\n".encode()


def test_stl_is_its_triangles(tmp_path_factory, subtests):
    """Binary or text, whatever the first word is: each point once, each triangle with its corners in order."""
    rows = [
        ("a.stl", binary_stl(CORNERS)),
        ("a.STL", binary_stl(CORNERS, b"solid, says the header of many a binary file")),
        ("a.stl", binary_stl(np.concatenate([CORNERS, [[POINTS[0], POINTS[0], POINTS[1]]]]))),  # one without an area
        ("a.stl", binary_stl(CORNERS) + b"a few bytes more"),
        ("a.stl", text_stl(CORNERS)),
        ("a.stl", text_stl(CORNERS).replace(b"\n", b"\r\n")),
        ("a.stl", text_stl(CORNERS).upper()),
    ]
    for name, data in rows:
        with subtests.test(name=name):
            tmp_path = tmp_path_factory.mktemp("case")
            (tmp_path / name).write_bytes(data)
            mesh = read_mesh(tmp_path / name)
            assert_array_equal(mesh.vertices, POINTS)
            assert_array_equal(mesh.vertices[mesh.faces], CORNERS)


def test_obj_is_its_points_and_polygons(tmp_path_factory, subtests):
    """Objects are taken as one, textures and normals are left, a polygon becomes a fan of triangles."""
    for faces in [
        "f 1 2 3 4",
        "f 1/1 2/2 3/3 4/4",
        "f 1//7 2//7 3//7 4//7",
        "f -4 -3 -2 -1",
        "f 1/1/1 2/2/2 3/3/3\nf 1 3 4",
        "f 1 2 \\\n3 4",
    ]:
        with subtests.test(faces=faces):
            tmp_path = tmp_path_factory.mktemp("case")
            points = "mtllib a.mtl\no one\nv 0 0 0\nv 1 0 0 1.0\nvn 0 0 1\nvt 0 0\no two\n  v 1 1 0\nv 0 1 0\n"
            (tmp_path / "a.obj").write_text(f"{points}usemtl m\n{faces}\nl 1 2\n")
            mesh = read_mesh(tmp_path / "a.obj")
            assert_array_equal(mesh.vertices, [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
            assert_array_equal(mesh.faces, [[0, 1, 2], [0, 2, 3]])


def test_bad_mesh_is_refused_in_one_line(tmp_path_factory, subtests):
    """The line names the file, what is wrong, and what to do."""
    for name, data, message in [
        ("a.step", b"", "is none of .stl, .obj, .dae, .glb, .gltf, .ply. Convert it to STL"),
        ("a.dae", b"<COLLADA/>", NONE),
        ("a.dae", b"<!DOCTYPE a [<!ENTITY b 'c'>]><COLLADA/>", "has a <!DOCTYPE a>, which none needs"),
        ("a.glb", b"glTF", NONE),
        ("a.gltf", b'{"buffers": [{"uri": "/dev/zero"}]}', "its numbers lie in other files: save it as .glb"),
        *((name, text.encode(), f"{told} are allowed") for name, text, told in HOSTILE),
        ("a.ply", b"ply\nformat ascii 1.0\nend_header\n", NONE),
        ("a.obj", b"", "it holds no points, or some"),
        ("a.stl", b"", "it holds no points, or some"),
        (
            "a.stl",
            b"version https://git-lfs.github.com/spec/v1\noid sha256:0\n",
            "is a Git LFS pointer: the file itself",
        ),
        ("a.obj", b"<!DOCTYPE html><html>", "is no mesh, it is a web page: download the file itself"),
        ("a.stl", binary_stl(CORNERS)[:-1], "it holds no points, or some"),
        ("a.stl", binary_stl(CORNERS * np.nan), "it holds no points, or some"),
        ("a.stl", text_stl(CORNERS).replace(b"vertex", b"corner", 1), "its last triangle is not complete"),
        ("a.dae", collada(CORNERS).replace("<p>0", "<p>7").encode(), NONE),
        ("a.ply", OUTSIDE, "triangles with corners that it does not have"),
        ("a.obj", b"v 1 2 x\n", NONE),
        ("a.obj", b"v 1 2 3\nf 1 a 1\n", NONE),
        ("a.obj", b"v 1 2 3\nv 1 2 4\nf 1 2 -3\n", "triangles with corners that it does not have"),
        ("a.stl", bytes(80) + struct.pack("<I", 1) + b"\x01\x00\xa0\x7f" * 12 + b"\0\0", NONE),
        ("a.stl", bytes(80) + struct.pack("<I", 1) + struct.pack("<12fH", *[1e38] * 12, 0), NONE),
        ("a.obj", b"v 1 2 3\nf 1 " + b"9" * 5_000 + b" 1\n", NONE),
        ("a.obj", b"v 1e400 0 0\n", NONE),
        ("a.obj", b"v 1\n", NONE),
        ("a.obj", b"v 1 2 3\nf  \n", NONE),
    ]:
        with subtests.test(name=name):
            tmp_path = tmp_path_factory.mktemp("case")
            (tmp_path / name).write_bytes(data)
            told = refuse(tmp_path / name)
            assert told.startswith(f"'{tmp_path / name}' ")
            assert message in told
            assert "\n" not in told


def test_mesh_that_changed_is_read_again(tmp_path):
    """A file is read once, until it changes; nobody can change what was read."""
    path = tmp_path / "a.obj"
    path.write_text("v 1 2 3\n")
    first = read_mesh(path)
    assert read_mesh(path) is first
    with pytest.raises(ValueError, match="read-only"):
        first.vertices[0] = 0.0
    path.write_text("v 4 5 6\n")
    os.utime(path, ns=(1, 1))
    assert_array_equal(read_mesh(path).vertices, [[4, 5, 6]])


@given(integers(0, 30).flatmap(lambda count: arrays(float, (count, 3), elements=sampled_from([-1.0, 0.0, 0.5, 2.0]))))
def test_distinct_points_are_those_of_numpy(points):
    """In the same order, with the same numbers; numpy's function only takes longer."""
    expected, numbers = np.unique(points, axis=0, return_inverse=True)
    found, found_numbers = distinct(points)
    assert_array_equal(found, expected)
    assert_array_equal(found_numbers, numbers.ravel())


OUTSIDE = b"""ply
format ascii 1.0
element vertex 3
property float x
property float y
property float z
element face 1
property list uchar int vertex_indices
end_header
0 0 0
1 0 0
0 1 0
3 0 1 7
"""
"""A PLY with a corner that it does not have."""
COLLADA = """<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="any" meter="{unit}"/><up_axis>{up}</up_axis></asset>
<library_geometries><geometry id="part"><mesh>
  <source id="points"><float_array id="numbers" count="{count}">{numbers}</float_array>
    <technique_common><accessor source="#numbers" count="{points}" stride="3">
      <param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/>
    </accessor></technique_common></source>
  <vertices id="corners"><input semantic="POSITION" source="#points"/></vertices>
  <triangles count="{triangles}"><input semantic="VERTEX" source="#corners" offset="0"/><p>{order}</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="scene"><node>
  <matrix>{matrix}</matrix><node><translate>0 0 5</translate><instance_geometry url="#part"/></node>
</node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#scene"/></scene>
</COLLADA>"""
"""A part in a node within a node."""
SHARED = ",".join(['{"attributes": {"POSITION": 0}}'] * 5)
HOSTILE = [
    ("a.gltf", '{"accessors": [{"co\\u0075nt": 5000000}]}', "5,000,000 entries of its arrays, 4,000,000"),
    ("a.gltf", f'{{"accessors": [{{"count": 1000000}}], "meshes": [{{"primitives": [{SHARED}]}}]}}', "4,000,000"),
    ("a.gltf", '{"bufferViews": [{"byteLength": 1000000000}]}', "bytes, 134,217,728"),
    ("a.gltf", '{"nodes": [' + "0," * 20_000 + "0]}", "20,001 nodes, 20,000"),
    ("a.gltf", "[" + "[]," * 100_001, "100,001 parts, 100,000"),
    ("a.ply", "ply\n" + "property list uchar int x\n" * 500, "bytes in its head, 10,000"),
    ("a.ply", "ply\nend_header" + "\n" * 800_000, "800,001 lines, 800,000"),
    ("a.ply", "ply\nend_header" + "0" * 2**25, "bytes, 33,554,432"),
    ("a.dae", "<a>" + " " * 12_000_001, "12,000,001 numbers, 12,000,000"),
    ("a.dae", "<a><vcount>700000</vcount></a>", "700,000 corners, 600,000"),
    ("a.dae", "<a>" + "".join(f'<b id="{it}">' + f'<b url="#{it + 1}"/>' * 9 + "</b>" for it in range(9)) + "</a>",
     "bytes, copies counted, 134,217,728"),
    ("a.dae", '<a id="1"><b url="#1"/></a>', "inf bytes, copies counted, 134,217,728"),
    ("a.obj", "f 1\n" * 200_002, "200,001 triangles or more, 200,000"),
]  # fmt: skip
"""Small texts of which others would make more than the memory holds."""
TURNED = np.array([[0, -2, 0, 7], [2, 0, 0, 8], [0, 0, 2, 9], [0, 0, 0, 1]])
MIRRORED = np.diag([1, 1, -1, 1])


def collada(corners, unit="1", up="Z_UP", pose=TURNED):
    """A COLLADA file of triangles, (count, 3, 3)."""
    points = 3 * len(corners)
    return COLLADA.format(
        unit=unit, up=up, count=3 * points, points=points, triangles=len(corners),
        numbers=" ".join(map(str, corners.ravel())), order=" ".join(map(str, range(points))),
        matrix=" ".join(map(str, pose.ravel())),
    )  # fmt: skip


def corners_of(path):
    """Of the triangles in a file, (count, 3, 3)."""
    mesh = read_mesh(path)
    return mesh.vertices[mesh.faces]


@pytest.mark.parametrize("up", ["X_UP", "Y_UP", "Z_UP"])
@pytest.mark.parametrize("unit", ["1", "0.0254"])
def test_collada_has_its_unit_and_its_own_axes(tmp_path, unit, up):
    """The file's nodes and its unit move the points; which axis is up turns nothing, as in RViz."""
    (tmp_path / "a.DAE").write_text(collada(CORNERS, unit, up))
    x, y, z = np.moveaxis(CORNERS + np.array([0, 0, 5]), -1, 0)
    expected = np.stack([7 - 2 * y, 8 + 2 * x, 9 + 2 * z], axis=-1) * float(unit)
    assert_allclose(corners_of(tmp_path / "a.DAE"), expected, rtol=1e-6)


def test_mirrored_part_is_not_turned_inside_out(tmp_path):
    """A node that mirrors would leave the corners clockwise."""
    for name, pose in (("plain", np.eye(4)), ("mirrored", MIRRORED)):
        (tmp_path / f"{name}.dae").write_text(collada(CORNERS, pose=pose))
    plain, mirrored = (
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        for corners in (corners_of(tmp_path / "plain.dae"), corners_of(tmp_path / "mirrored.dae"))
    )
    assert_allclose(mirrored, plain * [1, 1, -1], atol=1e-6)


@pytest.mark.parametrize("suffix", ["glb", "gltf", "ply"])
def test_scene_that_another_library_wrote(tmp_path, suffix):
    """The points are those that it was given, in place; glTF is not turned, though its y axis points up."""
    part = trimesh.Trimesh(CORNERS.reshape(-1, 3), np.arange(6).reshape(-1, 3), process=False)
    scene = trimesh.Scene()
    scene.add_geometry(part, transform=TURNED)
    path = tmp_path / f"a.{suffix}"
    data = scene.to_mesh().export(file_type="ply") if suffix == "ply" else scene.export(file_type="glb")
    if suffix == "gltf":
        data = trimesh.exchange.gltf.export_gltf(scene, embed_buffers=True)["model.gltf"]
    path.write_bytes(data)
    expected = CORNERS @ TURNED[:3, :3].T + TURNED[:3, 3]
    assert_allclose(corners_of(path), expected, rtol=1e-6)


@pytest.mark.parametrize("missing", ["trimesh", "collada"])
def test_format_without_its_reader_says_what_to_install(tmp_path, monkeypatch, missing):
    """What is read without it stays readable."""
    (tmp_path / "a.dae").write_text(collada(CORNERS))
    monkeypatch.setitem(sys.modules, missing, None)
    assert "is no STL or OBJ file. To have it read: pip install 'fd100-harness[meshes]'" in refuse(tmp_path / "a.dae")
    names = ["a.dae", "a.DAE", "a.glb", "a.gltf", "a.ply", "a.stl", "a.obj", "a.step"]
    expected = [True] * 2 + [missing == "trimesh"] * 3 + [False] * 3
    assert [needs_extra(Path(name)) for name in names] == expected


@pytest.mark.parametrize(
    "name",
    ["../meshes/a.stl", "package://arm_description/meshes/a.stl", "package://checked_out_elsewhere/meshes/a.stl",
     "model://arm_description/meshes/a.stl"],
)  # fmt: skip
def test_mesh_is_found_from_the_folder_of_the_urdf(tmp_path, name):
    """Relative names start there; packages are looked for around it, also where the checkout has another name."""
    package = tmp_path / "arm_description"
    (package / "urdf").mkdir(parents=True)
    (package / "meshes").mkdir()
    mesh = package / "meshes" / "a.stl"
    mesh.touch()
    assert locate_mesh(name, package / "urdf").samefile(mesh)
    assert locate_mesh(f"file://{mesh}", Path("/")) == mesh
    assert locate_mesh(str(mesh), Path("/")) == mesh


@pytest.mark.parametrize(
    ("name", "message"),
    [
        (
            "a.stl",
            "has the mesh 'a.stl', and there is no file '{}/a.stl'. Put it there, say in a robot.toml where such names",
        ),
        ("", "has the mesh '', and there is no file '{}'"),
        ("package://p/a.stl", "there is no file '{}/p/a.stl', nor one in the folders around it. Put it"),
        ("package://p/a.stl", 'say in a robot.toml where the package lies, meshes = {{ "p" = "FOLDER" }}'),
        *(
            (name, "there is no file")
            for name in ("x" * 5_000 + ".stl", "package://" + "a/" * 3_000, "/dev/zero", "a\0b.stl")
        ),
        ("http://host/a.stl", "has the mesh 'http://host/a.stl': allowed are paths, package://, model:// and file://"),
    ],
)
def test_missing_mesh_is_refused(tmp_path, name, message):
    """The line names the mesh and where it was looked for first."""
    with refused(re.escape(message.format(tmp_path))):
        locate_mesh(name, tmp_path)


def refuse(path):
    """The line that a file is refused with."""
    with pytest.raises(UsageError) as refused:
        read_mesh(path)
    assert str(path) in str(refused.value)
    return str(refused.value)


def test_a_large_mesh_is_not_opened(tmp_path):
    """A sparse file of 2 GB is refused at once, by who reads it and by who looks for it."""
    path = tmp_path / "a.stl"
    with path.open("wb") as file:
        file.truncate(2 * 10**9)
    assert "2,000,000,000 bytes, 67,108,864 are allowed" in refuse(path)
    with refused("2,000,000,000 bytes, 67,108,864 are allowed"):
        locate_mesh("a.stl", tmp_path)


@pytest.mark.parametrize(
    ("name", "data"),
    [
        ("a.stl", bytes(80) + struct.pack("<I", 240_000) + bytes(240_000 * 50)),
        ("a.stl", b"\nvertex 0 0 0" * 600_003),
        ("a.obj", b"\nv 0 0 0" * 600_003),
        ("a.obj", b"v 0 0 0\n" + b"f 1 1" + b" 1" * 200_001),
    ],
    ids=["binary", "text", "points", "polygon"],
)
def test_too_many_triangles_are_refused(tmp_path, name, data):
    """With how many there are, and how many may be."""
    (tmp_path / name).write_bytes(data)
    assert re.search(r"it has 2\d\d,\d\d\d triangles or more, 200,000 are allowed", refuse(tmp_path / name))


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes in the file system")
def test_a_pipe_is_no_mesh(tmp_path):
    """To read it would take forever."""
    os.mkfifo(tmp_path / "a.stl")
    assert "it is no regular file" in refuse(tmp_path / "a.stl")
    with refused("there is no file"):
        locate_mesh("a.stl", tmp_path)


def mesh_at(place):
    """An empty file, with the folders that it lies in."""
    place.parent.mkdir(parents=True)
    place.touch()
    return place


def test_packages_lie_where_they_are_said_to(tmp_path):
    """One by its name, all others in one folder or as it; that comes before a file in the URDF's folder or around it.

    Some URDFs count relative names from the folder of the program that loads them.
    """
    near, named = mesh_at(tmp_path / "urdf" / "pack" / "a.stl"), mesh_at(tmp_path / "elsewhere" / "a.stl")
    held, around = mesh_at(tmp_path / "all" / "pack" / "a.stl"), mesh_at(tmp_path / "pack" / "a.stl")
    every, its = {"": tmp_path / "all"}, {"": named.parent}
    for name, folder, packages, found in [
        ("package://pack/a.stl", "urdf", {}, near),
        ("package://pack/a.stl", "other", {}, around),
        ("package://pack/a.stl", "urdf", {"pack": named.parent}, named),
        ("package://pack/a.stl", "urdf", every, held),
        ("package://other/a.stl", "urdf", its, named),
        ("package://pack/a.stl", "urdf", {"other": named.parent}, near),
        ("pack/a.stl", "urdf", every, near),
        ("pack/a.stl", "other", every, held),
    ]:
        assert locate_mesh(name, tmp_path / folder, packages) == found


@pytest.mark.parametrize(
    ("variable", "folders", "place"),
    [
        ("ROS_PACKAGE_PATH", ["none", "src"], "src/pack/a.stl"),
        ("ROS_PACKAGE_PATH", ["src"], "src/several/pack/a.stl"),
        ("ROS_PACKAGE_PATH", ["src/pack"], "src/pack/a.stl"),
        ("AMENT_PREFIX_PATH", ["none", "install"], "install/share/pack/a.stl"),
    ],
)
def test_packages_lie_where_ros_looks(tmp_path, monkeypatch, variable, folders, place):
    """In the folders that its variables name; one beside the URDF comes first."""
    far = mesh_at(tmp_path / place)
    monkeypatch.setenv(variable, os.pathsep.join(str(tmp_path / folder) for folder in folders))
    assert locate_mesh("package://pack/a.stl", tmp_path / "urdf") == far
    near = mesh_at(tmp_path / "urdf" / "pack" / "a.stl")
    assert locate_mesh("package://pack/a.stl", tmp_path / "urdf") == near
