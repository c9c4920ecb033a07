"""What an arm looks like: triangles by joint, and pictures of them."""

from typing import TYPE_CHECKING

from harness.face import face_of

if TYPE_CHECKING:
    from harness.scene.picture import Camera as Camera, StillFrames as StillFrames, camera_for as camera_for
    from harness.scene.scene import scene_of as scene_of
else:
    __all__, __getattr__ = face_of(__name__, __file__)
