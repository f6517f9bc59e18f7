"""Pictures of steady sliding: pressure and stiffness p(x) of each contact."""

from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure

from cea.arrays import Floats
from cea.contact.contact import Contact
from cea.system.steady_state import ContactState
from comparisons.study.plots import BLUE, STYLE, save
from scenes import Result


def draw_contacts(result: Result, out: Path) -> list[Path]:
    """Draw the steady sliding state of each contact with a contact law; return the files.

    In space the view is along the axis in which the contact is thinnest; in the plane values are
    drawn along the axis in which it is longest.
    """
    states = result.steady.contacts if result.steady is not None else {}
    files = []
    for contact in result.system.contacts:
        if contact.name not in states:
            continue
        name = quote(contact.name, safe=" ,")
        files.append(out / f"contact_{result.scene.backends}_{name}.png")
        if result.comm.rank == 0:
            with rc_context(STYLE):
                save(draw_contact(contact, states[contact.name]), files[-1])
    return files


def draw_contact(contact: Contact, state: ContactState) -> Figure:
    """Draw pressure and stiffness of a half pass in two panels."""
    in_plane = contact.interface.points.x.shape[1] == 2
    figure = Figure(figsize=(7.0, 4.2) if in_plane else (8.5, 4.2), layout="constrained")
    panels = figure.subplots(2, 1, sharex=True) if in_plane else figure.subplots(1, 2)
    draw = _along if in_plane else _seen
    draw(panels[0], contact, state.pressure, "contact pressure (N/m$^2$)")
    draw(panels[1], contact, state.stiffness, "stiffness p (N/m$^3$)")
    share = 100 * state.closed_fraction
    figure.suptitle(
        f"{contact.name}: normal force {state.normal_force:.4g} N, {share:.3g} % of the area closed"
    )
    return figure


def _along(axes: Any, contact: Contact, values: Floats, title: str) -> None:
    """Draw values along a contact in the plane."""
    x = contact.interface.points.x
    axis = int(np.argmax(np.ptp(x, axis=0)))
    order = np.argsort(x[:, axis], kind="stable")
    axes.plot(x[order, axis], values[order], ".-", color=BLUE, linewidth=0.8, markersize=4)
    axes.set(ylabel=title, xlabel=f"{'xy'[axis]} (m)")
    axes.label_outer()


def _seen(axes: Any, contact: Contact, values: Floats, title: str) -> None:
    """Draw values at the points of a contact in space; open points have the value zero."""
    x = contact.interface.points.x
    across = np.delete(range(3), np.argmin(np.ptp(x, axis=0)))
    dots = axes.scatter(*x[:, across].T, s=9.0, c=values, linewidths=0, vmin=0.0)
    axes.figure.colorbar(dots, ax=axes, shrink=0.85)
    names = (f"{'xyz'[axis]} (m)" for axis in across)
    axes.set(aspect="equal", title=title, xlabel=next(names), ylabel=next(names))
