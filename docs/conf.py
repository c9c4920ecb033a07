"""The site: Sphinx, MyST and furo. `make docs` builds it, and a warning is an error."""

import sys
from importlib.metadata import version as version_of
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "site"))

project = "fd100-harness"
author = project_copyright = "the fd100-harness authors"
version = release = version_of("fd100-harness")

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx_copybutton", "generated_pages"]
exclude_patterns = ["_build"]

myst_enable_extensions = ["colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3

html_theme = "furo"
html_title = "fd100-harness"

autodoc_typehints = "description"
autodoc_member_order = "bysource"
napoleon_use_ivar = True
