"""An example plugin: an arm by a URDF with meshes."""
