"""Built-in formats of robots beside URDF; `harness_robots` announces them."""
