"""The public arms of arms.toml, a row each: what loads, where its tip is, what trains, and whether engines agree.

    python experiments/arms/measure.py results/reference/arms/arms.csv [NAME ...]

measures all arms, or those named, two at a time, and writes a page beside the rows; `make arms` sets up what it needs.
Each is called three ways: by its absolute path, by a relative one, and from the folder of its file.
"""

import csv
import json
import os
import re
import subprocess
import sys
import tempfile
import time
import tomllib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from sysconfig import get_path
from typing import Any

import mujoco
import numpy as np
import pinocchio
from numpy.typing import NDArray

from harness.errors import UsageError
from harness.registry.allowed import allow_programs
from harness.robot import Robot
from harness.robot.packages import find_installed, package_folders
from harness.robot.robot import load_robot
from harness.text import print_visible

ARMS = Path(__file__).parent / "arms.toml"
SIMULATORS = ("kinematic", "mujoco", "pybullet")
TRAINING = "--algo sac-fast --steps 500 --seeds 1 --reward baseline --baseline none --evaluation-episodes 2 --jobs 1"
"""sac-fast learns from its 100th step on: 400 updates."""
MOTIONS = "--episodes 2 --steps 20"
POSES = 20
AT_ONCE = 2


@dataclass(frozen=True)
class Row:
    """What was found of one arm.

    Attributes:
        name: What people call it.
        file: Where it comes from.
        joints: How many move; 0 if it is refused.
        tip_error: Largest distance of the tip from what another program computes at 20 random poses, [m].
        trains: The simulators in which 500 steps were trained.
        apart: Largest distance of the tips in two simulators under the same smooth motion, [m].
        seconds: How long all this took.
        refused: The sentences that refuse something.
    """

    name: str
    file: str
    joints: int = 0
    tip_error: float = float("nan")
    trains: str = ""
    apart: float = float("nan")
    seconds: float = 0.0
    refused: str = ""


def measure(arm: Mapping[str, Any]) -> Row:
    """One arm of arms.toml, with a robot.toml of its own, called three ways.

    It is loaded by an absolute path, trained from the file's own folder, and held against other simulators by a
    relative path.
    """
    begin = time.perf_counter()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "robot.toml").write_text(robot_toml(arm), encoding="utf-8")
        row = _measure(Row(arm["name"], arm["file"]), arm, folder)
        refused = row.refused.replace(f"{folder}/", "").replace(f"{get_path('purelib')}/", "")
    return replace(row, seconds=time.perf_counter() - begin, refused=refused)


def _measure(row: Row, arm: Mapping[str, Any], folder: Path) -> Row:
    try:
        robot = load_robot(folder)
    except UsageError as error:
        return replace(row, refused=str(error))
    row = replace(row, joints=robot.dof)
    if robot.end_effector_link != arm["tip"]:
        return replace(row, refused=f"The tip is '{robot.end_effector_link}', not '{arm['tip']}'.")
    row = replace(row, tip_error=_tip_error(robot, arm))
    laid = lay_out(arm, folder / "laid")
    cells, refused = _harness("run", f"{TRAINING} --out {folder / 'out'} --quiet", laid.parent, laid.name)
    done = [cell["simulator"] for cell in cells.get("cells", []) if cell["status"] == "done" and cell["steps"] == 500]
    held, refused_parity = _harness("parity", MOTIONS, folder, str(laid.relative_to(folder)))
    apart = max((pair["max_tip_error_m"] for pair in held.get("pairs", [])), default=float("nan"))
    return replace(row, trains=" ".join(sorted(done)), apart=apart, refused=f"{refused} {refused_parity}".strip())


def lay_out(arm: Mapping[str, Any], folder: Path) -> Path:
    """The file of an arm in folders of links to what lies beside it and around it, with its robot.toml; its path."""
    root = Path(get_path("purelib"))
    file = find_installed(arm["file"]).relative_to(root)
    for inner in file.parents[:-1]:
        (folder / inner).mkdir(parents=True, exist_ok=True)
        for beside in (root / inner).iterdir():
            if not (folder / inner / beside.name).exists():
                (folder / inner / beside.name).symlink_to(beside)
    (folder / file).with_name("robot.toml").write_text(robot_toml({**arm, "file": file.name}), encoding="utf-8")
    return folder / file


def _harness(command: str, options: str, folder: Path, robot: str) -> tuple[dict[str, Any], str]:
    """What a command in a folder says in JSON, and what it says went wrong."""
    words = [*options.split(), "--sim", ",".join(SIMULATORS), "--robot", robot, "--json"]
    done = subprocess.run(
        [sys.executable, "-m", "harness", command, *words], capture_output=True, text=True, check=False, cwd=folder
    )
    said = json.loads(done.stdout) if done.stdout.lstrip().startswith("{") else {}
    wrong = [line.removeprefix("harness: ") for line in done.stderr.splitlines() if line.startswith("harness: ")]
    wrong += [cell["reason"] for cell in said.get("cells", []) if cell["status"] != "done"]
    wrong += ["TRACEBACK"] * ("Traceback" in done.stderr)
    return said, " ".join(wrong) if done.returncode else ""


def robot_toml(arm: Mapping[str, Any]) -> str:
    """The robot.toml that its owner writes."""
    keys = {"urdf": arm["file"], **arm.get("robot", {})}
    return "".join(f"{key} = {_toml(value)}\n" for key, value in keys.items())


def _toml(value: object) -> str:
    if isinstance(value, dict):
        return f"{{ {', '.join(f'{json.dumps(key)} = {_toml(held)}' for key, held in value.items())} }}"
    return json.dumps(value)


def _tip_error(robot: Robot, arm: Mapping[str, Any]) -> float:
    """Against Pinocchio, which reads URDFs with ROS's parser; of MJCF against MuJoCo, with the file as it came, [m]."""
    file, settings = find_installed(arm["file"]), arm.get("robot", {})
    poses = np.random.default_rng(0).uniform(robot.lower, robot.upper, (POSES, robot.dof))
    held = {name: np.deg2rad(angle) for name, angle in settings.get("fixed", {}).items()}
    tips = _mujoco_tips if file.suffix == ".xml" else _pinocchio_tips
    given = [{**held, **dict(zip(robot.joint_names, pose, strict=True))} for pose in poses]
    found = np.array(list(tips(file, arm["tip"], given))) + settings.get("base", {}).get("xyz_m", [0.0, 0.0, 0.0])
    return float(np.abs(robot.end_effector(poses) - found).max())


def _pinocchio_tips(file: Path, tip: str, poses: Iterable[Mapping[str, float]]) -> Iterator[NDArray[np.float64]]:
    text = _expand(file) if file.suffix == ".xacro" else file.read_text(encoding="utf-8")
    for name in ("effort", "velocity"):  # ROS's parser wants both, which move no tip
        text = re.sub(rf"<limit\b(?![^>]*\b{name}\s*=)", f'<limit {name}="0"', text)
    model = pinocchio.buildModelFromXML(text)
    data, frame = model.createData(), model.getFrameId(tip, pinocchio.FrameType.BODY)
    for pose in poses:
        qpos = pinocchio.neutral(model)
        for name, position in pose.items():
            joint = model.joints[model.getJointId(name)]
            turn = [np.cos(position), np.sin(position)]  # what Pinocchio has of a continuous joint
            qpos[joint.idx_q : joint.idx_q + joint.nq] = turn if joint.nq == 2 else [position]
        pinocchio.framesForwardKinematics(model, data, qpos)
        yield data.oMf[frame].translation.copy()


def _expand(file: Path) -> str:
    """What the package xacro makes of a file; a package that is not found is the folder around it."""
    import xacro.substitution_args

    xacro.substitution_args._eval_find = lambda name: str(
        next(filter(os.path.isdir, package_folders(name, file.parent, {})), file.parents[1])
    )
    return str(xacro.process_file(str(file)).toxml())


def _mujoco_tips(file: Path, tip: str, poses: Iterable[Mapping[str, float]]) -> Iterator[NDArray[np.float64]]:
    model = mujoco.MjModel.from_xml_path(str(file))
    data = mujoco.MjData(model)
    is_site = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SITE, tip) >= 0
    for pose in poses:
        for name, position in pose.items():
            data.joint(name).qpos[:] = position
        mujoco.mj_kinematics(model, data)
        yield (data.site(tip) if is_site else data.body(tip)).xpos.copy()


def table(rows: Iterable[Row]) -> str:
    """The rows in Markdown: distances in metres and millimetres."""
    lines = ["| arm | file | joints | tip, m | trains | apart, mm | s |", "| --- | --- | --- | --- | --- | --- | --- |"]
    for row in rows:
        kind = {"urdf": "URDF", "xml": "MJCF"}.get(row.file.rpartition(".")[2], "xacro")
        trains = "all" if len(row.trains.split()) == len(SIMULATORS) else row.trains or "no"
        apart = "refused" if np.isnan(row.apart) else f"{1000 * row.apart:.2g}"
        found = f"{row.joints} | {row.tip_error:.0e} | {trains} | {apart}" if row.joints else "refused | | |"
        lines.append(f"| {row.name} | {kind} | {found} | {row.seconds:.0f} |")
    return "\n".join(lines)


def _page(rows: Sequence[Row]) -> str:
    right = [row for row in rows if not row.refused]
    refused = [f"* **{row.name}.** {row.refused}" for row in rows if row.refused]
    head = (
        f"# Public arms\n\nMade by `make arms`: {len(right)} of {len(rows)} are right in everything. *tip* is the "
        f"largest distance from what Pinocchio or MuJoCo says in {POSES} poses, *trains* says in which simulators 500 "
        "steps were trained, *apart* how far the tips of two simulators are in the same motion.\n"
    )
    return "\n".join([head, table(rows), *(["", "## Refused", "", *refused] if refused else []), ""])


def read(path: Path) -> list[Row]:
    """The rows of a file that `main` wrote."""
    with path.open(encoding="utf-8", newline="") as file:
        return [Row(**{it.name: it.type(line[it.name]) for it in fields(Row)}) for line in csv.DictReader(file)]


def write(path: Path, rows: Iterable[Row]) -> None:
    """The rows as CSV, for `read`, and as a page beside it."""
    rows = list(rows)
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, [it.name for it in fields(Row)], lineterminator="\n")
        writer.writeheader()
        writer.writerows(map(asdict, rows))
    path.with_name("README.md").write_text(_page(rows), encoding="utf-8")


def main(path: Path, names: Sequence[str]) -> None:
    """Measure the arms of these names, or all; the rows of others stay."""
    known = tomllib.loads(ARMS.read_text(encoding="utf-8"))["arm"]
    rows = {row.name: row for row in read(path)} if path.exists() else {}
    allow_programs(str(find_installed(arm["file"])) for arm in known if arm["file"].endswith(".xacro"))
    with ThreadPoolExecutor(AT_ONCE) as pool:
        for row in pool.map(measure, [arm for arm in known if not names or arm["name"] in names]):
            rows[row.name] = row
            write(path, [rows[arm["name"]] for arm in known if arm["name"] in rows])
            print_visible(f"{table([row]).splitlines()[-1]} {row.refused}")


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2:])
