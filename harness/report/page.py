"""One HTML file that opens anywhere, offline."""

import os
from contextlib import suppress
from pathlib import Path
from typing import Any

from harness.errors import UsageError


def render_page(template: Path, noun: str, **values: Any) -> str:
    """The page that `template` makes of `values` and of ``plotly_js``, the library that draws its figures.

    Raises:
        UsageError: A library of the extra ``report`` is missing; `noun` says what for.
    """
    try:
        import jinja2
        from plotly.offline import get_plotlyjs
    except ImportError as error:
        raise UsageError(f"{noun} needs {error.name}: pip install 'fd100-harness[report]'") from error
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(template.parent),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template(template.name).render(**values, plotly_js=get_plotlyjs())


def write_page(page: str, path: Path, noun: str) -> None:
    """Write `page` to `path`, in one go: a reader finds the old file or the new one, whole.

    Raises:
        UsageError: `path` cannot be written.
    """
    temporary = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        temporary.write_text(page, encoding="utf-8")
        os.replace(temporary, path)
    except OSError as error:
        raise UsageError(f"{noun} '{path}' cannot be written: {error.strerror}") from error
    finally:
        with suppress(OSError):  # gone if it was renamed, never there if it could not be written
            temporary.unlink()
