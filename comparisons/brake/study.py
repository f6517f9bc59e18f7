"""``ventilated_brake`` on a sequence of refined meshes.

Modes are matched from mesh to mesh by eigenvalue and by shape on the contact surfaces. The spread
of their frequencies measures the error. Contacts use mortar, because GPTS on quadratic elements is
not usable at this contact stiffness (``cea study accuracy``).
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import pandas as pd

from cea.eigen.matching import connected
from cea.errors import InputError
from comparisons.study.measure import measured
from comparisons.study.numbers import decimals, number, per_cent, plain
from comparisons.study.sections import Column, Section, Table, diagram
from comparisons.study.shapes import mode_rows
from comparisons.study.study import Case, Session, Study, StudyResult
from scenes.results.matching import match_runs
from scenes.spec.reading import Scene, load_scene

SCENE = "ventilated_brake"
_PARTNERS = 1e-10  # relative distance of the frequencies of a growing mode and its decaying partner


@dataclass(frozen=True)
class Options:
    """Options of the study; sizes must be given and decrease."""

    sizes: Annotated[tuple[float, ...], "Edge lengths of tetrahedra (m), decreasing."] = (
        0.012,
        0.0075,
        0.006,
    )
    overrides: Annotated[tuple[str, ...], "Fields of the scene, as with --set."] = ()

    def __post_init__(self) -> None:
        falling = all(a > b > 0 for a, b in pairwise(self.sizes))
        if not self.sizes or not falling or not self.sizes[0] > 0:
            raise InputError("sizes", self.sizes, "one or more positive lengths (m), decreasing")


def cases(options: Options) -> Iterator[Case]:
    """Every mesh."""
    for size in options.sizes:
        yield {"size": size}


def scene(case: Case, options: Options) -> Scene:
    """Return ``ventilated_brake`` with one target edge length in disc and pads."""
    brake = load_scene(Path(SCENE), options.overrides)
    return brake.change({f"bodies.{name}.mesh.fe.size": case["size"] for name in brake.bodies})


def evaluate(case: Case, session: Session) -> dict[str, list[dict[str, Any]]]:
    """Return the run, its modes, and their matches with modes of the next coarser mesh."""
    sizes, matches = session.options.sizes, []
    before = [size for size in sizes if size > case["size"]]
    coarser = None
    if before:  # cached, unless the study was resumed here
        coarser = session.solve(scene({"size": before[-1]}, session.options))
    with measured() as cost:
        result = session.solve()
    if coarser is not None:
        for group in match_runs(coarser, result).groups:
            numbers = {"first": group.first.tolist(), "second": group.second.tolist()}
            matches.append(numbers | {"assurance": group.assurance})
    name = f"{case['size']:g}"
    finest = case["size"] == sizes[-1]
    modes = session.keep_modes(name, result) if finest else mode_rows(name, result)
    run = {
        "dofs": result.dofs,
        "modes": len(modes),
        "unstable": sum(row["verdict"] == "unstable" for row in modes),
        "complete": bool(result.modes.window.complete),
        "seconds": result.timer.total,
        "memory": result.comm.allreduce(cost.memory or 0.0) / 1e3 or None,
    }
    return {"brake_runs": [run], "modes": modes, "matches": matches}


def brake_modes(result: StudyResult) -> pd.DataFrame:
    """Every mode, or group of nearly coalescing modes, of the finest mesh on all meshes."""
    modes = result.frame("modes")
    sizes = list(modes["size"].unique())
    by_size = [modes[modes["size"] == size].reset_index(drop=True) for size in sizes]
    rows = []
    for members in _over_meshes(result, by_size):
        found = [own.iloc[numbers] for own, numbers in zip(by_size, members, strict=True)]
        means = [own["frequency"].mean() for own in found]
        known = pd.Series(means).dropna()
        last = found[-1].loc[found[-1]["growth"].idxmax()]
        row: dict[str, Any] = {"mode": ", ".join(str(i + 1) for i in members[-1])}
        row |= {f"frequency_{s * 1e3:g}mm": m for s, m in zip(sizes, means, strict=True)}
        row["spread"] = (max(known) - min(known)) / means[-1] if len(known) > 1 else None
        growths = {s: own["growth"].max() for s, own in zip(sizes, found, strict=True)}
        row |= {f"growth_{s * 1e3:g}mm": growth for s, growth in growths.items()}
        rows.append(row | {"damping_ratio": last["damping_ratio"], "verdict": last["verdict"]})
    return pd.DataFrame(rows)


def _over_meshes(result: StudyResult, by_size: list[pd.DataFrame]) -> Iterator[list[list[int]]]:
    """Groups of matched modes on all meshes; a growing mode and its partner are one group."""
    every = result.frame("matches")
    sizes = [own["size"].iloc[0] for own in by_size[1:]]
    matches = [every[every["size"] == size].to_dict("records") for size in sizes]
    frequencies = by_size[-1]["frequency"].to_numpy()
    linked = np.isclose(frequencies[:, None], frequencies, rtol=_PARTNERS, atol=0.0)
    for group in matches[-1] if matches else ():
        linked[np.ix_(group["second"], group["second"])] = True
    for members in connected(linked):
        chain = [members.tolist()]
        for match in reversed(matches):
            before = [g["first"] for g in match if set(g["second"]) & set(chain[0])]
            chain.insert(0, sorted({i for first in before for i in first}))
        yield chain


def headline(result: StudyResult) -> str:
    """State the unstable pairs on the finest mesh and the spread of their frequencies."""
    grow = brake_modes(result)
    grow = grow[grow["verdict"] == "unstable"]
    spread = number(100 * grow["spread"].max(), 2) if grow["spread"].notna().any() else "–"
    return f"{len(grow)} unstable pairs on the finest mesh; their frequencies spread by {spread} %."


OWN = {
    "size": Column("size", "m", plain),
    "unstable": Column("unstable pairs", show=number),
    "seconds": Column("seconds", "s", decimals(0)),
    "memory": Column("memory", "GB", decimals(1)),
    "spread": Column("spread", "%", per_cent),
}
STUDY = Study(
    name="brake",
    title="A ventilated brake between two pads",
    options=Options,
    cases=cases,
    scene=scene,
    evaluate=evaluate,
    shipped=Path(__file__).with_name("results"),
    quick={
        "sizes": (0.04, 0.03),
        "overrides": (
            *(f"bodies.{b}.mesh.fe.degree=1" for b in ("disc", "lower_pad", "upper_pad")),
            "bodies.disc.geometry={shape='annulus',inner_radius=0.08,outer_radius=0.18,bottom=0,top=0.035}",
            "bodies.disc.supports=[{surface='inner'}]",
            "contacts.lower.b=disc.bottom",
            "contacts.upper.b=disc.top",
        ),
    },
    sections=[
        Section(
            "Meshes",
            "Modes of the finest mesh and the matching modes of the others. Modes that nearly "
            "coalesce are shown by their mean frequency and largest growth rate.",
            headline,
            [
                Table("brake_runs", "Every mesh.", "brake_runs", OWN, printed=True),
                Table("brake_modes", "Modes on all meshes.", brake_modes, OWN, printed=True),
            ],
            [diagram("brake", "Every mode of every mesh.", "modes", ("size",), own=OWN)],
            modes=True,
            of="modes",
        ),
    ],
)
