"""What an arm looks like: triangles by joint, and pictures of them."""

from typing import TYPE_CHECKING, Any

from harness.face import look_up

if TYPE_CHECKING:
    from harness.scene.picture import Camera, StillFrames, camera_for
    from harness.scene.scene import scene_of

__all__ = [
    "Camera",
    "StillFrames",
    "camera_for",
    "scene_of",
]

_HOMES = {
    "picture": "Camera StillFrames camera_for",
    "scene": "scene_of",
}


def __getattr__(name: str) -> Any:
    return look_up(__name__, _HOMES, name)
