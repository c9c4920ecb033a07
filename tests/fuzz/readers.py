"""Every way from a file, or a text, of anybody into the program, with valid content to begin with."""

import json
import shutil
import struct
from collections.abc import Callable
from pathlib import Path
from random import Random
from typing import Any, NamedTuple

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import safetensors.numpy
import trimesh
from numpy.random import default_rng

from harness import load_robot
from harness.experiment.plan import check_experiment, expand, read_experiment
from harness.files.bounded import seal, unseal
from harness.log import open_logs
from harness.motion.motion import JointLimits
from harness.policy import (
    Greedy,
    SquashedGaussian,
    UniformChoice,
    load_policy,
)
from harness.policy.inverse_kinematics import InverseKinematics
from harness.record import (
    SCALARS,
    Manifest,
    Store,
    TraceWriter,
    TrainingFacts,
    read_manifest,
    read_recording,
    read_trace,
)
from harness.record.dataset.labels import SuccessRule, read_labels
from harness.record.folder import CARD, SCENE, WEIGHTS
from harness.record.recording.recording_writer import RecordingWriter
from harness.record.scene import read_scene, write_scene
from harness.registry import choose
from harness.registry.toml_file import read_toml
from harness.robot import read_mesh
from harness.robot.robot import read_robot
from harness.scene.scene import scene_of
from harness.score.open_steps import open_steps
from harness_plugins.audit import page_in
from tests.fuzz.mutate import (
    mutate_bytes,
    mutate_csv,
    mutate_json,
    mutate_text,
    mutate_toml,
    mutate_xml,
)
from tests.plugins.audit.search.certified import whole_certificate
from tests.record.dataset.frames import write_frames
from tests.record.dataset.written import episode, opened, write_lerobot, write_minari
from tests.registered import FD100
from tests.robot.test_meshes import CORNERS, collada
from tests.stores import create_store

Mutate = Callable[[bytes, Random], bytes]


class Reader(NamedTuple):
    """One of them.

    Attributes:
        files: Valid content by the file's name.
        mutate: How each file is made wrong, by its name; other files stay valid.
        read: Gets the folder.
    """

    files: dict[str, bytes]
    mutate: dict[str, Mutate]
    read: Callable[[Path], Any]


URDF = b"""<robot name="arm">
  <link name="base"/>
  <link name="upper"><inertial><origin xyz="0 0 1" rpy="0 0 0"/><mass value="1"/>
    <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><origin xyz="0 0 1" rpy="0 1 0"/><geometry><box size="0.1 0.2 0.3"/></geometry></collision></link>
  <link name="lower"><collision><geometry><mesh filename="part.stl" scale="1 1 2"/></geometry></collision></link>
  <link name="slider"><collision><geometry><cylinder radius="0.1" length="1"/></geometry></collision></link>
  <link name="tip"/> <link name="finger"/>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><origin xyz="0 0 5" rpy="0 0 1"/>
    <axis xyz="0 0 1"/><limit lower="-1" upper="2" velocity="1.5" effort="1"/></joint>
  <joint name="elbow" type="continuous"><parent link="upper"/><child link="lower"/><origin xyz="0.5 0 0"/>
    <axis xyz="0 1 0"/><limit velocity="2" effort="1"/></joint>
  <joint name="slide" type="prismatic"><parent link="lower"/><child link="slider"/><axis xyz="0 0 1"/>
    <limit lower="-0.2" upper="0.1" velocity="0.5" effort="1"/></joint>
  <joint name="mount" type="fixed"><parent link="slider"/><child link="tip"/><origin xyz="0.25 0 0"/></joint>
  <joint name="grip" type="prismatic"><parent link="tip"/><child link="finger"/>
    <limit lower="0.1" upper="0.2" velocity="1"/></joint>
</robot>"""
ROBOT_TOML = b"""name = "arm"
urdf = "arm.urdf"
end_effector = "tip"
home_deg = [0, 90]
home_m = [0.05]
max_speed_deg_s = [80, 100.0]
max_speed_m_s = [0.25]
max_acceleration_deg_s2 = [360, 720]
max_acceleration_m_s2 = [2]
range_deg = [[-10, 50], [-90, 120]]
chain = ["base", "mount"]
fixed = { grip = 0.15 }
meshes = { arm = "." }
base = { xyz_m = [0, 0, 0.5], rpy_deg = [0, 0, 10] }
tool = { xyz_m = [0.1, 0, 0], name = "probe" }
"""
TRIANGLES = [[0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0], [0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 0, 0]]
STL = bytes(80) + struct.pack("<I", 2) + b"".join(struct.pack("<12fH", *corners, 0) for corners in TRIANGLES)
TEXT_STL = b"solid a\nfacet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1e0 0\nendloop\nendfacet\n"
OBJ = b"# points\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1/1/1 2/2/2 -1 3\n"
DAE = collada(CORNERS, "0.001").encode()
GLB, PLY = (
    trimesh.Trimesh(CORNERS.reshape(-1, 3), [[0, 1, 2], [3, 4, 5]]).export(file_type=each) for each in ("glb", "ply")
)
CSV = b"""t,beginDistance,prevBest,distance,delta_distance,reward,target x
0,1.11,1.11,1.11,0,0,1
1,1.11,0.5,0.5,-0.61,0.915,1
,1.11,0.5,0.75,,-0.25,1
0,1.11,1.11,1.11,0,0,1
"""
EXPERIMENT = b"""sim = ["ideal"]
algo = ["wander", {name = "wander"}]
reward = ["arp:k1=2,k2=1.5", {name = "arp", k1 = 1.0}]
baseline = "baseline"
task = {name = "fd100-reach", horizon = 5, epsilon = 0.02}
seeds = [0, 1]
steps = 12
evaluation_episodes = 2
evaluate_every = 6
deterministic = true
"""
TEXTS = {
    "rewards": b"arp:k1=1,k2=1.5",
    "tasks": b"fd100-reach:horizon=5,epsilon=0.02",
    "algorithms": b"sac:learning_rate=1e-3,net_arch=64x64",
    "executors": b"processes",
}


def readers(registry, cell, folder):
    """All of them, by name.

    Args:
        registry: The plugins, toys included.
        cell: Any.
        folder: To write examples into.
    """
    return {
        "csv": Reader({"a.csv": CSV}, {"a.csv": mutate_csv}, lambda at: _exhaust(at / "a.csv")),
        "toml": Reader({"a.toml": EXPERIMENT}, {"a.toml": mutate_toml}, lambda at: read_toml(at / "a.toml", "file")),
        "experiment": Reader(
            {"a.toml": EXPERIMENT},
            {"a.toml": mutate_toml},
            lambda at: expand(read_experiment(at / "a.toml", {}), registry),
        ),
        "urdf": Reader(
            {"arm.urdf": URDF, "part.stl": STL}, {"arm.urdf": mutate_xml}, lambda at: read_robot(at / "arm.urdf")
        ),
        "robot": Reader(
            {"r/arm.urdf": URDF, "r/part.stl": STL, "r/robot.toml": ROBOT_TOML},
            {"r/robot.toml": mutate_toml, "r/part.stl": mutate_bytes},
            lambda at: load_robot(at / "r"),
        ),
        "binary stl": Reader({"a.stl": STL}, {"a.stl": mutate_bytes}, lambda at: read_mesh(at / "a.stl")),
        "text stl": Reader({"b.stl": TEXT_STL}, {"b.stl": mutate_bytes}, lambda at: read_mesh(at / "b.stl")),
        "collada": Reader({"a.dae": DAE}, {"a.dae": mutate_xml}, lambda at: read_mesh(at / "a.dae")),
        "glb": Reader({"a.glb": GLB}, {"a.glb": mutate_bytes}, lambda at: read_mesh(at / "a.glb")),
        "ply": Reader({"a.ply": PLY}, {"a.ply": mutate_bytes}, lambda at: read_mesh(at / "a.ply")),
        "obj": Reader({"a.obj": OBJ}, {"a.obj": mutate_bytes}, lambda at: read_mesh(at / "a.obj")),
        **{f"policy {policy.kind}": _policy(policy, folder) for policy in _policies()},
        **{f"text of {kind}": _text(registry, kind, text) for kind, text in TEXTS.items()},
        "recorded trace": Reader(
            {"a.parquet": _trace(folder)}, {"a.parquet": _mutate_parquet}, lambda at: _exhaust(at / "a.parquet")
        ),
        "trace": Reader(
            {"a.parquet": _trace(folder)},
            {"a.parquet": _mutate_parquet},
            lambda at: read_trace(at / "a.parquet").rows(),
        ),
        **_datasets(folder),
        **{
            name: _example(registry, name, folder / name)
            for name in ("d4rl", "robomimic", "evaluations", "tensorboard")
        },
        "recorded training": _recorded_training(folder, "recording-0.json", _mutate_sealed),
        "steps of a recorded training": _recorded_training(folder, "steps-0-00000.parquet", _mutate_parquet),
        "certificate": _certificate(),
        "scene": Reader({"scene.json": _scene(folder)}, {"scene.json": mutate_json}, read_scene),
        **_sealed("manifest", "m/manifest.json", _manifest(cell, folder), lambda at: read_manifest(at / "m")),
        **_sealed("plan", "p/plan.json", _plan(registry, folder), lambda at: Store.open(at / "p").read_plan()),
    }


def _sealed(name, path, content, read):
    """A file that carries its own digest, and the same as version 0.1 wrote it: what is changed there is read."""
    plain = json.dumps({**unseal(content), "format": 1}).encode()
    return {
        name: Reader({path: plain}, {path: mutate_json}, read),
        f"sealed {name}": Reader({path: content}, {path: mutate_json}, read),
    }


def _datasets(folder):
    """A data set of each format; what its numbers lie in, and what it tells of itself, are made wrong."""
    minari = write_minari(folder / "minari", [episode(6, success=True, operator="a"), episode(4, 1)])
    lerobot = write_lerobot(folder / "lerobot", [episode(6, success=True), episode(4, 1)])

    def reader(kind, place, name, mutate):
        files = {
            f"{kind}/{path.relative_to(place).as_posix()}": path.read_bytes()
            for path in place.rglob("*")
            if path.is_file()
        }
        return Reader(files, {f"{kind}/{name}": mutate}, lambda at: _exhaust_dataset(f"{kind}:{at / kind}"))

    frames, episodes = "data/chunk-000/file-000.parquet", "meta/episodes/chunk-000/file-000.parquet"
    lists = write_frames(folder / "lists", [{"observation.state": np.zeros((3, 2)), "action": np.zeros((3, 2))}] * 2)
    lines = write_frames(
        folder / "lines", [{"observation.state": np.zeros((3, 2)), "action": np.zeros((3, 2))}], "v2.1"
    )
    return {
        "episodes of lerobot": reader("lerobot", lists, episodes, _mutate_parquet),
        "lines of lerobot": reader("lerobot", lines, "meta/episodes.jsonl", mutate_json),
        "labels": Reader(
            {"labels.csv": b"episode,success\n0,1\n1,false\n"},
            {"labels.csv": mutate_csv},
            lambda at: read_labels(at / "labels.csv", SuccessRule()),
        ),
        "minari": reader("minari", minari, "data/main_data.hdf5", mutate_bytes),
        "facts of minari": reader("minari", minari, "data/metadata.json", mutate_json),
        "lerobot": reader("lerobot", lerobot, frames, _mutate_parquet),
        "facts of lerobot": reader("lerobot", lerobot, "meta/info.json", mutate_json),
    }


def _exhaust_dataset(name):
    log = opened(name)
    for _ in log.tables(log.names):
        pass


def _example(registry, name, folder):
    """The file that a format of logs writes as its example."""
    folder.mkdir()
    choose(registry, "logs", name).build(registry, "logs").write_example(folder)
    (path,) = folder.iterdir()

    def read(at):
        for log in open_logs(at / path.name, registry, name):
            for _ in log.tables(log.names):
                pass

    return Reader({path.name: path.read_bytes()}, {path.name: mutate_bytes}, read)


def _recorded_training(folder, name, mutate):
    """Of two recorders with one part each; one file of the first is made wrong."""
    place, facts = folder / "recorded", TrainingFacts(rewards=("v1", "v2"), trained_with="v2", behaviour=("success",))
    shutil.rmtree(place, ignore_errors=True)
    for number in range(2):
        writer = RecordingWriter(place, facts, number)
        writer.append([[time, 0, time // 5, time % 5, 0.5, -1.5, 1.0, time % 5 == 4, False] for time in range(12)])
        writer.close()
    files = {path.name: path.read_bytes() for path in place.iterdir() if path.suffix != ".lock"}
    return Reader(files, {name: mutate}, lambda place: read_recording(place).rows())


def _mutate_sealed(content, rng):
    """Bytes that differ, or another content that is sealed as if it were right."""
    if rng.random() < 0.3:
        return mutate_bytes(content, rng)
    try:
        return seal(json.loads(mutate_json(json.dumps(unseal(content)).encode(), rng)))
    except (ValueError, TypeError, RecursionError):  # no JSON object any more, or one too deep to be made
        return mutate_bytes(content, rng)


def _certificate():
    """A certificate that holds all that one may hold, and its page."""
    content = seal(whole_certificate().to_json())
    return Reader({"c.json": content}, {"c.json": _mutate_sealed}, lambda at: page_in(at / "c.json"))


def _exhaust(path):
    for _ in (log := open_steps(path)).pieces(log.columns):
        pass


def _text(registry, kind, text):
    def read(folder):
        choose(registry, kind, (folder / "text").read_text(errors="surrogateescape"))

    return Reader({"text": text}, {"text": mutate_text}, read)


def _policies():
    rng = default_rng(0)

    def layers(*sizes):
        weights = {f"{name}.weight": rng.normal(size=(out, into)) for name, into, out in sizes}
        weights |= {f"{name}.bias": rng.normal(size=out) for name, _, out in sizes}
        return {name: array.astype(np.float32) for name, array in weights.items()}

    hidden = (("hidden.0", 5, 4), ("hidden.1", 4, 4))
    scaling = {f"observation.{name}": np.ones(5, np.float32) for name in ("mean", "std")}
    gaussian = layers(*hidden, ("mean", 4, 2), ("log_std", 4, 2)) | scaling
    limits = JointLimits(FD100.lower, FD100.upper, FD100.max_speed, FD100.max_acceleration * 0.02, 0.02)
    return [
        SquashedGaussian(gaussian, "tanh", (-1.0, -1.0), (1.0, 1.0), "sac"),
        Greedy(layers(*hidden, ("value", 4, 3)), "relu", 3, "dqn", epsilon=0.1),
        UniformChoice(7, "floor"),
        InverseKinematics.of(FD100, limits, "movej", "ik"),
    ]


def _policy(policy, folder):
    place = folder / "policy" / policy.kind
    policy.save(place)
    files = {f"{policy.kind}/{name}": (place / name).read_bytes() for name in (CARD, WEIGHTS)}
    mutate = {f"{policy.kind}/{CARD}": mutate_json, f"{policy.kind}/{WEIGHTS}": _mutate_weights}
    return Reader(files, mutate, lambda at: load_policy(at / policy.kind))


def _mutate_weights(content, rng):
    """Other bytes; or arrays of other types, shapes and numbers."""
    if rng.random() < 0.5:
        return mutate_bytes(content, rng)
    arrays = {name: np.array(array) for name, array in safetensors.numpy.load(content).items()}
    name = rng.choice(list(arrays) or ["mean.weight"])
    shape = rng.choice(((), (0,), (4,), (4, 4), (5, 4), (0, 10**9), (2, 2, 2), (3_000,)))
    other = np.full(shape, rng.choice((0.0, 1.0, -1.0, np.nan, np.inf, 3e38)))
    match rng.randrange(4):
        case 0:
            arrays.pop(name, None)
        case 1:
            arrays[rng.choice(("x", "hidden.00.weight", "hidden.9.bias", "hidden..weight", "\u202e"))] = other
        case _:
            arrays[name] = other
    kind = rng.choice((np.float32, np.float32, np.float32, np.float64, np.int8, np.bool_, np.float16))
    with np.errstate(all="ignore"):
        return safetensors.numpy.save({name: array.astype(kind) for name, array in arrays.items()})


def _trace(folder):
    path = folder / "trace.parquet"
    with TraceWriter(path, 3, 2) as writer:
        writer.append(np.tile(np.arange(len(SCALARS) + 5.0), (6, 1)))
    return path.read_bytes()


def _mutate_parquet(content, rng):
    """Other bytes, anywhere or where the file tells of its columns; or other columns, and another format."""
    if rng.random() < 0.3:
        return mutate_bytes(content, rng)
    if rng.random() < 0.4:
        data = bytearray(content)
        end = len(data) - 8
        for _ in range(rng.choice((1, 1, 2, 3))):
            data[rng.randrange(end - int.from_bytes(content[-8:-4], "little"), end)] = rng.choice(
                (0, 1, 127, 255, rng.randrange(256))
            )
        return bytes(data)
    # In this thread: others of Arrow would give back `content`, python's own, while `tracemalloc` ends, and crash it.
    table = pq.ParquetFile(pa.BufferReader(content), pre_buffer=False).read(use_threads=False)
    for _ in range(rng.choice((1, 1, 3))):
        column = rng.randrange(table.num_columns)
        name = rng.choice((table.column_names[column], table.column_names[column], rng.choice(table.column_names), "x"))
        match rng.randrange(4):
            case 0 if table.num_columns > 1:
                table = table.remove_column(column)
            case 1:
                table = table.append_column(name, table.column(column))
            case _:
                table = table.set_column(column, name, _odd_column(len(table), rng))
    if rng.random() < 0.3:
        keys = {
            b"harness.trace": rng.choice((b"", b"1", b"-1", b"x", b"\xff", b"9" * 5_000)),
            b"harness.facts": rng.choice((b"", b"{}", b"[" * 9_999)),
        }
        table = table.replace_schema_metadata(keys)
    sink = pa.BufferOutputStream()
    pq.write_table(table.slice(0, rng.choice((0, 1, len(table), len(table)))), sink)
    return bytes(sink.getvalue())


def _odd_column(rows, rng):
    value = rng.choice(
        (None, True, 7, -(2**62), 1e308, float("nan"), float("inf"), "x", b"x", [1.0], [], [[1]], {"a": 1})
    )
    if rng.random() < 0.3:
        return pa.array([0.5] * (rows - 1) + [None])
    return pa.array([value] * rows)


def _scene(folder):
    write_scene(scene_of(FD100), folder)
    return (folder / SCENE).read_bytes()


def _manifest(cell, folder):
    place = folder / "manifest"
    place.mkdir()
    environment = {"versions": {"numpy": "2"}, "machine": {"cpu": "x", "cores": 2}, "commit": "abc", "command": "a"}
    record = Manifest(
        cell=cell, status="done", started="2026-01-01T00:00:00+00:00", seconds=1.0, environment=environment
    )
    record.write(place)
    return (place / "manifest.json").read_bytes()


def _plan(registry, folder):
    experiment = check_experiment({"sim": "ideal", "algo": "wander", "steps": 12, "seeds": 2})
    create_store(folder / "plan", expand(experiment, registry))
    return (folder / "plan" / "plan.json").read_bytes()
