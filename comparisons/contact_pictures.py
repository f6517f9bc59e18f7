"""Pictures of steady sliding: pressure and stiffness p(x) of each contact."""

from pathlib import Path
from urllib.parse import quote

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure

from cea.contact.contact import Contact
from cea.system.steady_state import ContactState
from comparisons.study.plots import BLUE, STYLE, save
from scenes import Result


def draw_contacts(result: Result, out: Path) -> list[Path]:
    """Draw the steady sliding state of each contact with a contact law; return the files."""
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
    """Draw pressure and stiffness over the axes across which a contact is not thinnest."""
    x = contact.interface.points.x
    across = np.delete(range(x.shape[1]), np.argmin(np.ptp(x, axis=0)))
    names = [f"{'xyz'[axis]} (m)" for axis in across]
    figure = Figure(figsize=(8.5, 4.2), layout="constrained")
    titles = {
        "contact pressure (N/m$^2$)": state.pressure,
        "stiffness p (N/m$^3$)": state.stiffness,
    }
    for axes, (title, values) in zip(figure.subplots(1, 2), titles.items(), strict=True):
        if len(across) == 1:
            order = np.argsort(x[:, across[0]], kind="stable")
            axes.plot(x[order, across[0]], values[order], ".-", color=BLUE)
            axes.set(title=title, xlabel=names[0])
            continue
        dots = axes.scatter(*x[:, across].T, s=9.0, c=values, linewidths=0, vmin=0.0)
        figure.colorbar(dots, ax=axes, shrink=0.85)
        axes.set(aspect="equal", title=title, xlabel=names[0], ylabel=names[1])
    share = 100 * state.closed_fraction
    figure.suptitle(
        f"{contact.name}: normal force {state.normal_force:.4g} N, {share:.3g} % of the area closed"
    )
    return figure
