"""Finds the packages, whose import names are not their folders' names; all else stands in pyproject.toml."""

from setuptools import find_namespace_packages, find_packages, setup

setup(
    packages=[
        *find_packages(include=["harness", "harness.*"]),
        "harness_plugins",
        *(f"harness_plugins.{name}" for name in find_packages("plugins")),
        "harness_robots",
        # Folders of a robot hold data alone, but setuptools calls every folder a package.
        *(f"harness_robots.{name}" for name in find_namespace_packages("robots")),
    ],
)
