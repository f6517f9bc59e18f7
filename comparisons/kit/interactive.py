"""Plots that a page draws itself: data and layout for plotly.js, and the library with it.

The library is that of the Python package plotly, compressed; pages ask nothing of a network.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from html import escape
from importlib.util import find_spec
from math import isfinite
from pathlib import Path
from typing import Any

from markupsafe import Markup

from comparisons.kit.binary import packed
from comparisons.kit.plots import BLUE, GREY, ORANGE, VERMILION

_HERE = Path(__file__).parent
_SCRIPTS = ("tables.js", "contents.js", "plots.js", "shapes.js", "viewer.js", "start.js")

VERDICT_MARKS = {
    "unstable": ("triangle-up", VERMILION, "▲"),
    "grows slowly": ("triangle-up-open", VERMILION, "△"),
    "undecided": ("diamond", ORANGE, "◆"),
    "stable": ("circle", BLUE, "●"),
    "rigid": ("circle-open", GREY, "○"),
}
"""Marker, colour and sign of each verdict: none is told by colour alone."""


@dataclass(frozen=True)
class Plot:
    """A plot that a page draws.

    Parameters
    ----------
    name
        Its name on the page, unique there.
    traces
        Traces of plotly.js.
    x, y
        Options of the axes, as plotly.js has them.
    height
        Height (pixels).
    title
        Title above it.
    file
        Name of the file with the same drawing or its data.
    options
        More of the layout.
    """

    name: str
    traces: Sequence[Mapping[str, Any]]
    x: Mapping[str, Any]
    y: Mapping[str, Any]
    height: int = 380
    title: str = ""
    file: str = ""
    options: Mapping[str, Any] = field(default_factory=dict)

    def plain(self) -> dict[str, Any]:
        """Plain data for plotly.js; what is no number is null."""
        figure = {
            "data": list(self.traces),
            "layout": {
                "xaxis": self.x,
                "yaxis": self.y,
                "height": self.height,
                **self.options,
            },
        }
        return finite(figure)


def finite(value: Any) -> Any:
    """Plain data with null in the place of numbers that are not finite."""
    if isinstance(value, float):
        return value if isfinite(value) else None
    if isinstance(value, Mapping):
        return {name: finite(part) for name, part in value.items()}
    if isinstance(value, list | tuple):
        return [finite(part) for part in value]
    return value


def literal(text: Any) -> str:
    """Text as plotly.js shows it, which reads tags in it."""
    return escape(str(text), quote=False)


def titled(text: str, **options: Any) -> dict[str, Any]:
    """Options of an axis with its title."""
    return {"title": {"text": literal(text)}, **options}


def logarithmic(text: str) -> dict[str, Any]:
    """Options of a logarithmic axis with its title."""
    return titled(text, type="log", exponentformat="power", dtick=1, minor={"ticks": "outside"})


def marks(verdict: str, **options: Any) -> dict[str, Any]:
    """Marker of the modes with a verdict."""
    symbol, colour, _ = VERDICT_MARKS[verdict]
    return {"symbol": symbol, "color": colour, **options}


def sign(verdict: str) -> str:
    """The word of a mode, or of a run, with its sign where it has one."""
    return f"{VERDICT_MARKS[verdict][2]} {verdict}" if verdict in VERDICT_MARKS else verdict


@cache
def library() -> str:
    """plotly.js as a page holds it: compressed with gzip, in base64.

    Raises
    ------
    ModuleNotFoundError
        Where the package plotly is not installed.
    """
    found = find_spec("plotly")
    if found is None or not found.submodule_search_locations:
        raise ModuleNotFoundError("plotly")
    folder = Path(found.submodule_search_locations[0])
    return packed((folder / "package_data" / "plotly.min.js").read_bytes())


@cache
def scripts() -> Markup:
    """Our own scripts of every page."""
    return Markup("\n".join((_HERE / "scripts" / name).read_text("utf-8") for name in _SCRIPTS))


@cache
def style() -> Markup:
    """Style of every page."""
    return Markup((_HERE / "style.css").read_text("utf-8"))
