"""One HTML file that opens anywhere, offline."""

from functools import lru_cache
from pathlib import Path
from typing import Any

from harness.errors import UsageError
from harness.files.whole_file import write_whole
from harness.report.figures.palette import STYLE
from harness.report.typography import to_html


def render_page(template: Path, noun: str, **values: Any) -> str:
    """The page that `template` makes of `values`; it may include what lies beside this module, such as the style sheet.

    Raises:
        UsageError: The extra ``report`` is missing; `noun` says what for.
    """
    try:
        import jinja2
    except ImportError as error:
        raise UsageError(f"{noun} needs {error.name}: pip install 'fd100-harness[report]'") from error
    page: str = _environment(template.parent, jinja2).get_template(template.name).render(**values)
    return page


@lru_cache(maxsize=8)
def _environment(folder: Path, jinja2: Any) -> Any:
    """One jinja2 environment for all pages of a folder's templates. It keeps the templates compiled."""
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader([folder, Path(__file__).parent, STYLE.parent]),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["typeset"] = _typeset
    return environment


def _typeset(text: str) -> Any:
    """A text as print has it, escaped: signs instead of letters, subscripts, narrow spaces before units."""
    from markupsafe import Markup

    return Markup(to_html(text))


def write_page(page: str, path: Path, noun: str) -> None:
    """Write `page` to `path`, in one go: a reader finds the old file or the new one, whole.

    Raises:
        UsageError: `path` cannot be written.
    """
    try:
        write_whole(path, page)
    except OSError as error:
        raise UsageError(f"{noun} '{path}' cannot be written: {error.strerror}") from error
