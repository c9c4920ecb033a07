"""Models that would hang MuJoCo or fill the memory, each written by its format's page."""

import os
import struct

ARM = """<mujoco model="arm">{head}<worldbody>
  <body name="base" pos="0 0 1"><joint name="turn" axis="0 0 1" range="-90 90"/><geom size="0.1"/>
    <body pos="0 0 0.3"><joint name="lift" axis="0 1 0" range="-90 90"/><geom size="0.1"/>
      <body pos="0 0 0.3"><joint name="bend" axis="0 1 0" range="-90 90"/><geom size="0.1"/></body>
    </body>
  </body>{body}</worldbody>{tail}</mujoco>"""


def arm(head="", body="", tail=""):
    """The text of an arm of three joints, with something besides."""
    return ARM.format(head=head, body=body, tail=tail)


def asset(text):
    """An arm with an asset."""
    return arm(f"<asset>{text}</asset>")


def attached(file):
    """An arm that holds another model."""
    return arm(f'<asset><model name="m" file="{file}"/></asset>', '<attach model="m" body="base" prefix="x"/>')


def sensed(text):
    """An arm with a sensor."""
    return arm(tail=f"<sensor>{text}</sensor>")


def _sparse(path):
    with path.open("wb") as file:
        file.truncate(2**31)


def _png(path, side):
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + struct.pack(">I4sIIBBBBB", 13, b"IHDR", side, side, 8, 2, 0, 0, 0))


def _chain(folder):
    """Models that each attach the next one ten times."""
    for level in range(9):
        inner = f'<model name="m" file="{level + 1}.xml"/>'
        ties = "".join(f'<attach model="m" body="base" prefix="{level}{copy}"/>' for copy in range(10))
        (folder / f"{level}.xml").write_text(arm(f"<asset>{inner}</asset>", ties))
    (folder / "9.xml").write_text(arm())


BESIDE = {
    "fifo": os.mkfifo,
    "sparse.stl": _sparse,
    "sparse.xml": _sparse,
    "huge.png": lambda path: _png(path, 100_000),
    "lying.stl": lambda path: path.write_bytes(bytes(80) + struct.pack("<I", 2**31)),
    "lying.bin": lambda path: path.write_bytes(struct.pack("<ii", 40_000, 40_000)),
    "0.xml": lambda path: _chain(path.parent),
}
"""Files that lie beside each model."""
MODELS = {
    "include: a pipe": arm('<include file="fifo"/>'),
    "include: a device": arm('<include file="/dev/zero"/>'),
    "include: a folder": arm('<include file="."/>'),
    "include: itself": arm('<include file="arm.xml"/>'),
    "include: too large": arm('<include file="sparse.xml"/>'),
    "replicate: a million": arm(body='<replicate count="1000000" offset="1 0 0"><geom size="1"/></replicate>'),
    "replicate: within one another": arm(
        body='<replicate count="1000"><replicate count="1000"><geom size="1"/></replicate></replicate>'
    ),
    "replicate: of an include": arm(body='<replicate count="90000"><include file="9.xml"/></replicate>'),
    "composite": arm(body='<composite type="cable" count="1000000 1 1"><geom size=".1"/></composite>'),
    "flexcomp": arm(body='<flexcomp name="f" type="grid" count="300 300 300" spacing=".1 .1 .1"/>'),
    "height field: 30,000 x 30,000": asset('<hfield name="h" nrow="30000" ncol="30000" size="1 1 1 1"/>'),
    "height field: a pipe": asset('<hfield name="h" file="fifo" size="1 1 1 1"/>'),
    "height field: a lying file": asset('<hfield name="h" file="lying.bin" size="1 1 1 1"/>'),
    "height field: a picture": asset('<hfield name="h" file="huge.png" size="1 1 1 1"/>'),
    "texture: 60,000 x 60,000": asset('<texture name="t" type="2d" builtin="flat" width="60000" height="60000"/>'),
    "texture: forty of them": asset(
        "".join(f'<texture name="t{it}" type="2d" builtin="flat" width="5000" height="5000"/>' for it in range(40))
    ),
    "texture: a lying picture": asset('<texture name="t" type="2d" file="huge.png"/>'),
    "texture: a pipe on one side": asset('<texture name="t" type="cube" fileright="fifo"/>'),
    "mesh: a pipe": asset('<mesh name="m" file="fifo"/>'),
    "mesh: a device": arm('<compiler meshdir="/dev"/><asset><mesh name="m" file="urandom"/></asset>'),
    "mesh: too large": asset('<mesh name="m" file="sparse.stl"/>'),
    "mesh: a lying file": asset('<mesh name="m" file="lying.stl"/>'),
    "mesh: made of itself": asset('<mesh name="m" builtin="supersphere" params="100000 1 1"/>'),
    "skin: a pipe": arm('<asset/><deformable><skin name="s" file="fifo"/></deformable>'),
    "attach: ten of ten of ten": attached("0.xml"),
    "attach: itself": attached("arm.xml"),
    "size: of what users keep": arm('<size nuserdata="2000000000"/>'),
    "size: of each body": arm('<size nuser_body="2000000000"/>'),
    "size: memory": arm('<size memory="1E"/>'),
    "custom numbers": arm("<custom><numeric name='n' size='2000000000'/></custom>"),
    "sensor: of a user": sensed('<user dim="2000000000"/>'),
    "compiler: the range of lengths": arm('<compiler><lengthrange inttotal="1e12"/></compiler>'),
    "elements: very many": arm(body="<geom size='1'/>" * 110_000),
    "elements: very deep": arm(body="<body>" * 5_000 + "</body>" * 5_000),
    "text: entities": '<!DOCTYPE m [<!ENTITY a "aaaaaaaaaa">]>' + arm(),
    "text: no UTF-8": arm("\ud800"),
}  # fmt: skip
"""Texts of such models, by what is wrong."""


def write_hostile(folder, name):
    """A model, and what lies beside all of them; its path."""
    for beside, write in BESIDE.items():
        write(folder / beside)
    path = folder / "arm.xml"
    path.write_bytes(MODELS[name].encode(errors="surrogatepass"))
    return path
