"""One HTML file that opens anywhere, offline."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from harness.errors import UsageError
from harness.files.whole_file import write_whole


def render_page(template: Path, noun: str, **values: Any) -> str:
    """The page that `template` makes of `values` and of ``plotly_js``, the library that draws its figures.

    Raises:
        UsageError: A library of the extra ``report`` is missing; `noun` says what for.
    """
    with _telling_what_is_missing(noun):
        from plotly.offline import get_plotlyjs
    return render_part(template, noun, **values, plotly_js=get_plotlyjs())


def render_part(template: Path, noun: str, **values: Any) -> str:
    """What `template` makes of `values`, every one of them escaped.

    Raises:
        UsageError: A library of the extra ``report`` is missing; `noun` says what for.
    """
    with _telling_what_is_missing(noun):
        import jinja2
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(template.parent),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template(template.name).render(**values)


@contextmanager
def _telling_what_is_missing(noun: str) -> Iterator[None]:
    try:
        yield
    except ImportError as error:
        raise UsageError(f"{noun} needs {error.name}: pip install 'fd100-harness[report]'") from error


def write_page(page: str, path: Path, noun: str) -> None:
    """Write `page` to `path`, in one go: a reader finds the old file or the new one, whole.

    Raises:
        UsageError: `path` cannot be written.
    """
    try:
        write_whole(path, page)
    except OSError as error:
        raise UsageError(f"{noun} '{path}' cannot be written: {error.strerror}") from error
