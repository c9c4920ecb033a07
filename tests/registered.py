"""What is installed, looked up once for all tests: plugins take as long to load as most tests to run."""

import harness

REGISTRY = harness.load_registry()
FD100, UNITY_ARM = (harness.load_robot(name, REGISTRY) for name in ("fd100", "unity-arm"))
