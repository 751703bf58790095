"""Pages that are one file: HTML with its style and figures inside, for screens, phones and print.

A template extends ``page.html`` (title, style, body) and has its own look besides only where it needs one.
"""

import base64
import io
from collections.abc import Callable, Mapping
from typing import Any

import matplotlib
from jinja2 import ChoiceLoader, Environment, PackageLoader, StrictUndefined
from matplotlib.figure import Figure

from jointattn_mj.io.figures import with_fonts
from jointattn_mj.io.progress import count

LARGEST_SVG = 300_000
"""Size in bytes above which a figure is shown as PNG."""
DPI = 150
"""Resolution of PNG figures."""
UNCHANGING: dict[Any, Any] = {"svg.hashsalt": "jointattn", "svg.fonttype": "path"}


def page(package: str, template: str, values: Mapping[str, Any], **filters: Callable[..., Any]) -> str:
    """Fill a template.

    Args:
        package: The package whose folder ``templates`` has it.
        template: Its name.
        values: What it shows. All text is escaped.
        filters: Functions that the template uses, beside ``count``.
    """
    environment = Environment(
        loader=ChoiceLoader([PackageLoader(package), PackageLoader("jointattn_mj.io")]),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters.update(count=count, **filters)
    return environment.get_template(template).render(**values)


def drawn(figure: Figure) -> tuple[bytes, str]:
    """A figure as the bytes of a PNG file, and as the data URI that a page shows: SVG where that is small."""
    drawing, image = io.BytesIO(), io.BytesIO()
    with matplotlib.rc_context(UNCHANGING), with_fonts(figure):
        figure.savefig(image, format="png", dpi=DPI, metadata={"Software": None})
        figure.savefig(drawing, format="svg", metadata={"Date": None, "Creator": None})
    small = len(drawing.getvalue()) <= LARGEST_SVG
    uri = data_uri("image/svg+xml", drawing.getvalue()) if small else data_uri("image/png", image.getvalue())
    return image.getvalue(), uri


def data_uri(kind: str, content: bytes) -> str:
    """Content as an address that holds it."""
    return f"data:{kind};base64,{base64.b64encode(content).decode()}"
