"""Pictures of steady sliding: pressure, closed zone and stiffness p(x) of each contact."""

from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.tri import Triangulation

from cea.arrays import Floats
from cea.contact.contact import Contact
from cea.system.steady_state import ContactState
from comparisons.study.plots import AXIS, BLUE, GREY, save
from scenes import Result

_OPEN = "#D9D9D9"
_FLAT = 0.5
"""Length of the mean unit normal from which a contact is seen along it."""
_LINE = 1e-6
"""Spread of points across a line, relative to their extent, that makes no surface."""
_FAR = 3.5
"""Distance between neighbours, in roots of the area weight of a point."""


def draw_contacts(result: Result, out: Path) -> list[Path]:
    """Draw what each contact with a law carries in steady sliding.

    In space seen along the coordinate nearest to the contact's mean normal, or in which it is
    thinnest where it is curved all round; in the plane values along the coordinate in which the
    contact is longest, near its closed part.

    Parameters
    ----------
    result
        A run; rank 0 draws.
    out
        Folder for the PNG files ``contact_<backend>_<half pass>.png``.

    Returns
    -------
    list of Path
        The files; none where no state of steady sliding was sought.
    """
    states = result.steady.contacts if result.steady is not None else {}
    files = []
    for contact in result.system.contacts:
        if contact.name not in states:
            continue
        name = quote(contact.name, safe=" ,")
        files.append(out / f"contact_{result.scene.backends}_{name}.png")
        if result.comm.rank == 0:
            save(draw_contact(contact, states[contact.name]), files[-1])
    return files


def draw_contact(contact: Contact, state: ContactState) -> Figure:
    """Pressure, closed zone and stiffness of a half pass beside each other."""
    points = contact.interface.points
    in_plane = points.x.shape[1] == 2
    size = (7.0, 6.0) if in_plane else (12.0, 4.2)
    figure = Figure(figsize=size, layout="constrained")
    panels = figure.subplots(3, 1, sharex=True) if in_plane else figure.subplots(1, 3)
    fields = (
        ("contact pressure (N/m$^2$)", state.pressure, "viridis"),
        ("closure (m)" if in_plane else "closed zone", state.closure, None),
        ("stiffness p (N/m$^3$)", state.stiffness, "magma"),
    )
    draw = _along if in_plane else _seen
    for axes, (title, values, colours) in zip(np.ravel(panels), fields, strict=True):
        draw(axes, contact, values, title, colours)
    if in_plane and state.closed_area:
        _narrow(np.ravel(panels), contact, state.closure)
    share = 100 * state.closed_fraction
    figure.suptitle(
        f"{contact.name}: normal force {state.normal_force:.4g} N, {share:.3g} % of the area closed"
    )
    return figure


def _along(axes: Any, contact: Contact, values: Floats, title: str, colours: str | None) -> None:
    """Values along a contact in the plane."""
    x = contact.interface.points.x
    axis = int(np.argmax(np.ptp(x, axis=0)))
    order = np.argsort(x[:, axis], kind="stable")
    place, shown = x[order, axis], values[order]
    axes.plot(place, shown, ".-", color=BLUE, linewidth=0.8, markersize=4)
    if colours is None:
        is_open = shown <= 0
        axes.plot(place[is_open], shown[is_open], ".", color=GREY, label="open")
        axes.axhline(0.0, color=AXIS, linewidth=0.7)
        axes.legend(loc="best", frameon=False)
    axes.set_ylabel(title)
    axes.set_xlabel(f"{'xy'[axis]} (m)")
    axes.label_outer()


def _narrow(panels: Any, contact: Contact, closure: Floats) -> None:
    """Show no more beside the closed part of a contact in the plane than that part is long."""
    x = contact.interface.points.x
    along = x[:, np.argmax(np.ptp(x, axis=0))]
    closed = along[closure > 0]
    length = max(float(np.ptp(closed)), 0.02 * float(np.ptp(along)))
    low, high = closed.min() - length, closed.max() + length
    near = (along >= low) & (along <= high)
    if near.all():
        return
    panels[0].set_xlim(low, high)
    shown = closure[near]
    margin = 0.05 * float(np.ptp(shown))
    panels[1].set_ylim(shown.min() - margin, shown.max() + margin)


def _seen(axes: Any, contact: Contact, values: Floats, title: str, colours: str | None) -> None:
    """Values over a contact in space: between points that are neighbours, and at them."""
    points = contact.interface.points
    across = _across(points.x, points.normal)
    centre = points.x[:, across]
    if colours is None:
        values = (values > 0).astype(float)
    look = ListedColormap([_OPEN, BLUE]) if colours is None else colours
    drawn: dict[str, Any] = {"cmap": look, "vmin": 0.0, "vmax": float(values.max()) or 1.0}
    net = _neighbours(centre, np.sqrt(points.weight))
    if net is not None:
        if colours is None:
            most = np.round(values[net.triangles].mean(axis=1))
            axes.tripcolor(net, facecolors=most, **drawn)
        else:
            axes.tripcolor(net, values, shading="gouraud", **drawn)
    dots = axes.scatter(*centre.T, s=2.0, c=values, linewidths=0, **drawn)
    if colours is not None:
        axes.figure.colorbar(dots, ax=axes, shrink=0.85)
    axes.set_aspect("equal")
    axes.set_title(title + (": blue is closed" if colours is None else ""))
    axes.set_xlabel(f"{'xyz'[across[0]]} (m)")
    axes.set_ylabel(f"{'xyz'[across[1]]} (m)")


def _neighbours(x: Floats, size: Floats) -> Triangulation | None:
    """Triangles between points that are no farther apart than their sizes allow, if there are any.

    Parameters
    ----------
    x
        Points, shape (n, 2).
    size
        Root of the area weight of each.
    """
    if np.linalg.matrix_rank(x - x.mean(axis=0), tol=_LINE * float(np.ptp(x))) < x.shape[1]:
        return None
    net = Triangulation(*x.T)
    corners = x[net.triangles]
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    far = sides > _FAR * size[net.triangles].mean(axis=1)
    net.set_mask(far)
    return None if far.all() else net


def _across(x: Floats, normal: Floats) -> list[int]:
    """The two coordinates over which a contact is drawn."""
    mean = np.abs(normal.mean(axis=0))
    thin = np.argmax(mean) if np.linalg.norm(mean) > _FLAT else np.argmin(np.ptp(x, axis=0))
    return [axis for axis in range(3) if axis != thin]
