"""Both backends beside each other: patch test, disc and pad with every formulation, disc alone."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from math import pi
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from cea.contact.formulations import Formulation, GaussPointToSurface, Greville, Grid, NodeToSurface
from comparisons.study.columns import Column
from comparisons.study.numbers import decimals, number, per_cent, shown
from comparisons.study.result import StudyResult
from comparisons.study.sections import Plot, Section, Table
from comparisons.study.session import Session
from comparisons.study.shapes import by_importance
from comparisons.study.study import Case, Study
from scenes import Result
from scenes.results.matching import match_unstable
from scenes.spec.body import Backend, FeMesh, IgaMesh, MeshSpec, backend_name
from scenes.spec.reading import BACKENDS, Scene, load_scene, on_backend, with_contact

EXPECTED = {
    ("Greville", 25, 1e14): 1722.0,
    ("Greville", 25, 1e6): 3233.0,
    ("grid", 81, 1e6): 1678.0,
    ("GPTS 15 x 15", 2025, 1e6): 0.446,
    ("GPTS 25 x 25", 5625, 1e6): 0.116,
}
"""Oscillation of sigma_n (N/m^2) on the worse side of the NURBS patch test, from an independent
prototype: by formulation, number of points and P (N/m)."""
KINDS = ("collocation", "grid", "GPTS")
"""Formulations of the disc and pad; collocation is in the manner of each backend."""
_MODES = 20
"""Frequencies of the disc alone that are compared."""
_REFERENCE = "reference"


def _graded(*distances: float) -> dict[str, tuple[float, ...]]:
    """Element boundaries at distances (m) from the clamped rim, where a singularity lies."""
    return {"r": tuple(0.06 + d for d in distances)}


DISC_MESHES: dict[str, list[FeMesh | IgaMesh]] = {
    "hexahedra, degree 2": [
        FeMesh("hexahedron", 2, elements=(n, 8 * n, max(1, n // 3))) for n in (3, 5, 8, 11)
    ],
    "hexahedra, degree 2, graded to the rim": [
        FeMesh("hexahedron", 2, elements=(4, 24, 1), through=_graded(0.006)),
        FeMesh("hexahedron", 2, elements=(6, 32, 2), through=_graded(0.002, 0.008)),
        FeMesh("hexahedron", 2, elements=(9, 48, 3), through=_graded(0.0005, 0.002, 0.006)),
    ],
    "tetrahedra, degree 2": [FeMesh("tetrahedron", 2, size=h) for h in (0.02, 0.012, 0.008)],
    "NURBS, degree 2": [IgaMesh((2, 2, 2), (n, 8 * n, max(1, n // 3))) for n in (3, 5, 8, 11, 15)],
    "NURBS, degree 3, graded to the rim": [
        IgaMesh((3, 3, 3), (4, 16, 1), through=_graded(0.006)),
        IgaMesh((3, 3, 3), (6, 24, 2), through=_graded(0.002, 0.008)),
        IgaMesh((3, 3, 3), (9, 32, 3), through=_graded(0.0005, 0.002, 0.006)),
    ],
    "NURBS, degree 4": [IgaMesh((4, 4, 4), (n, 8 * n, 1)) for n in (2, 4, 6)],
}
"""Meshes of the disc alone: lines of the plot of error against run time, rising in cost."""
_CORNERS = {"r": (0.0602, 0.0606, 0.0615, 0.0635, 0.068), "z": (0.0005, 0.002, 0.01, 0.0115)}
"""Boundaries of the reference of the disc alone, graded to both clamped corners (m)."""


@dataclass(frozen=True)
class Options:
    """Options of the comparison.

    Parameters
    ----------
    parts
        patch_test, disc_pad, disc_alone.
    gauss
        GPTS points per direction in each element of the patch test.
    disc_meshes
        Meshes of each line of the disc alone, at most.
    reference
        Elements along r, around and along z of the reference of the disc alone.
    overrides
        Changes of the disc_pad scene.
    """

    parts: tuple[str, ...] = ("patch_test", "disc_pad", "disc_alone")
    gauss: tuple[int, ...] = (15, 25)
    disc_meshes: int = 9
    reference: tuple[int, ...] = (11, 32, 6)
    overrides: tuple[str, ...] = ()


def formulations(backend: Backend, gauss: tuple[int, ...], grid: int) -> dict[str, Formulation]:
    """Collocation in the manner of the backend, a grid, and GPTS, by name."""
    own = NodeToSurface() if backend == "fe" else Greville()
    named: dict[str, Formulation] = {own.name: own, "grid": Grid(grid)}
    return named | {f"GPTS {n} x {n}": GaussPointToSurface(n) for n in gauss}


def cases(options: Options) -> Iterator[Case]:
    """Runs of the patch test; the disc and pad on both backends; meshes of the disc."""
    for backend in BACKENDS:
        for name in _of_patch_test(backend, options):
            for P in (1e6, 1e14):
                if "patch_test" in options.parts:
                    yield {"part": "patch_test", "backend": backend, "formulation": name, "P": P}
    for kind in KINDS:
        if "disc_pad" in options.parts:
            yield {"part": "disc_pad", "kind": kind}
    for line, meshes in DISC_MESHES.items():
        for mesh in meshes[: options.disc_meshes]:
            if "disc_alone" in options.parts:
                yield {"part": "disc_alone", "line": line, "mesh": _mesh_words(mesh)}
    if "disc_alone" in options.parts:
        yield {
            "part": "disc_alone",
            "line": _REFERENCE,
            "mesh": " x ".join(map(str, options.reference)),
        }


def _of_patch_test(backend: Backend, options: Options) -> dict[str, Formulation]:
    return formulations(backend, options.gauss, 9 if backend == "iga" else 4)


def _mesh_words(mesh: FeMesh | IgaMesh) -> str:
    if isinstance(mesh, FeMesh) and mesh.elements is None:
        return f"size {mesh.size} m"
    assert mesh.elements is not None
    return " x ".join(map(str, mesh.elements))


def scene(case: Case, options: Options) -> Scene | None:
    """Scene of a case; the disc and pad has one for each backend."""
    if case["part"] == "patch_test":
        patch = on_backend(load_scene(Path("patch_test")), case["backend"])
        chosen = _of_patch_test(case["backend"], options)[case["formulation"]]
        return with_contact(patch, formulation=chosen, P=case["P"])
    if case["part"] == "disc_alone":
        disc = load_scene(Path("disc"))
        mesh = _disc_mesh(case, options)
        spec = MeshSpec(fe=mesh) if isinstance(mesh, FeMesh) else MeshSpec(iga=mesh)
        body = replace(disc.bodies["disc"], backend=_backend(mesh), mesh=spec)
        return replace(disc, bodies={"disc": body})
    return None


def _disc_mesh(case: Case, options: Options) -> FeMesh | IgaMesh:
    if case["line"] == _REFERENCE:
        r, around, z = options.reference
        return IgaMesh((4, 4, 4), (r, around, z), through=_CORNERS)
    meshes = DISC_MESHES[case["line"]]
    return next(mesh for mesh in meshes if _mesh_words(mesh) == case["mesh"])


def _backend(mesh: FeMesh | IgaMesh) -> Backend:
    return "fe" if isinstance(mesh, FeMesh) else "iga"


def pad_scene(backend: Backend, kind: str, options: Options) -> Scene:
    """The disc and pad on a backend with a formulation."""
    pad = on_backend(load_scene(Path("disc_pad"), options.overrides), backend)
    named = formulations(backend, (5,), 10 if backend == "iga" else 4)
    return with_contact(pad, formulation=list(named.values())[KINDS.index(kind)])


def evaluate(case: Case, session: Session) -> dict[str, list[dict[str, Any]]]:
    """A case of its part."""
    if case["part"] == "patch_test":
        return _patch_test(case, session)
    return _disc_pad(case, session) if case["part"] == "disc_pad" else _disc_alone(session)


def _patch_test(case: Case, session: Session) -> dict[str, list[dict[str, Any]]]:
    """Oscillation of sigma_n on both sides, and sigma_n along the diagonal."""
    result = session.solve()
    (interface,), (sides,) = result.interfaces.values(), result.stresses.values()
    a, b = (sides[side].oscillation for side in "ab")
    key = case["formulation"], len(interface.points), case["P"]
    expected = EXPECTED.get(key) if case["backend"] == "iga" else None
    row = {
        "points": len(interface.points),
        "oscillation_a": a,
        "oscillation_b": b,
        "oscillation": max(a, b),
        "expected": expected,
        "ratio": max(a, b) / expected if expected else None,
    }
    along = [
        {"side": side, "arc": float(arc), "sigma_n": None if np.isnan(sigma) else float(sigma)}
        for side, s in sides.items()
        for arc, sigma in zip(s.arc, s.sigma_n_along, strict=True)
    ]
    return {"patch_test": [row], "patch_stresses": along}


def _disc_pad(case: Case, session: Session) -> dict[str, list[dict[str, Any]]]:
    """Modes of the disc and pad on both backends, and the unstable ones paired."""
    results = {b: session.solve(pad_scene(b, case["kind"], session.options)) for b in BACKENDS}
    modes, windows = [], []
    for backend, result in results.items():
        name = f"{case['kind']}-{backend}".replace(" ", "-")
        labels = {"backend": backend, "formulation": _formulation_of(result)}
        rows = result.table()
        kept = [i for i in by_importance(result) if rows[i]["verdict"] != "stable"]
        session.keep_modes(name, result, kept, f"{backend_name(backend)}, {labels['formulation']}")
        modes += [
            labels
            | {
                "shape": f"{name}/{row['mode']}",
                "mode": row["mode"],
                "frequency": row["frequency"],
                "growth": row["growth_rate"],
                "residual": row["residual"],
                "condition": row["condition"],
                "unstable": row["verdict"] == "unstable",
            }
            for row in rows
        ]
        windows.append(labels | _window(result))
    pairs = list(_paired(match_unstable(results["fe"], results["iga"])))
    return {"eigenvalues": modes, "windows": windows, "agreement": pairs}


def _formulation_of(result: Result) -> str:
    (contact,) = result.scene.contacts.values()
    rule = contact.formulation
    n = getattr(rule, "points", None)
    return f"{rule.name} {n} x {n}" if isinstance(rule, GaussPointToSurface) else rule.name


def _window(result: Result) -> dict[str, Any]:
    """What was searched, and the largest errors of what was found."""
    window, rows = result.modes.window, result.table()
    points = [interface.points for interface in result.interfaces.values()]
    return {
        "dofs": result.dofs,
        "points": sum(map(len, points)),
        "modes": len(rows),
        "complete": bool(window.complete),
        "residual": max((row["residual"] for row in rows), default=None),
        "condition": max((row["condition"] for row in rows), default=None),
        "evidence": window.evidence,
    }


def _paired(found: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """Unstable modes of both backends, each beside its partner."""
    keys = ("frequency", "growth")
    for pair in found["pairs"]:
        row: dict[str, Any] = {"found_by": "both"}
        for key in keys:
            row |= {f"{key}_{b}": v for b, v in zip(BACKENDS, pair[key], strict=True)}
            row[f"{key}_difference"] = pair[f"{key}_difference"]
        yield row | {"modal_assurance": pair["modal_assurance"]}
    for backend, modes in zip(BACKENDS, (found["only_first"], found["only_second"]), strict=True):
        for mode in modes:
            alone = f"{backend_name(backend)} only"
            yield {"found_by": alone} | {f"{key}_{backend}": mode[key] for key in keys}


def _disc_alone(session: Session) -> dict[str, list[dict[str, Any]]]:
    """First frequencies of the disc without pad."""
    result = session.solve()
    seconds = sum(result.timer.seconds.values())
    backend = next(iter(result.scene.bodies.values())).backend
    frequencies = (result.eigenvalues.imag[:_MODES] / (2 * pi)).tolist()
    return {
        "disc_runs": [{"backend": backend, "dofs": result.dofs, "seconds": seconds}],
        "disc_frequencies": [
            {"mode": i, "frequency": value} for i, value in enumerate(frequencies, 1)
        ],
    }


def of_part(table: str) -> Any:
    """Makes the frame of a table, without the labels that only set parts apart."""
    return lambda result: result.frame(table).drop(columns=["part", "kind"], errors="ignore")


def unstable(result: StudyResult) -> pd.DataFrame:
    """Unstable modes of the disc and pad."""
    frame = of_part("eigenvalues")(result)
    return frame if frame.empty else frame[frame["unstable"]].drop(columns="unstable")


def agreement(result: StudyResult) -> pd.DataFrame:
    """Unstable modes of both backends, paired."""
    frame = result.frame("agreement").drop(columns="part", errors="ignore")
    return frame.rename(columns={"kind": "formulation"})


def disc_frequencies(result: StudyResult) -> pd.DataFrame:
    """Frequencies of the disc alone beside the reference."""
    frame = of_part("disc_frequencies")(result)
    if frame.empty:
        return frame
    right = frame[frame["line"] == _REFERENCE].set_index("mode")["frequency"]
    return frame.assign(reference=frame["mode"].map(right))


def disc_alone(result: StudyResult) -> pd.DataFrame:
    """Worst and median error of the frequencies of each mesh against run time and dofs."""
    frame = disc_frequencies(result)
    if frame.empty:
        return frame
    frame["error"] = (frame["frequency"] / frame["reference"] - 1).abs()
    errors = frame.groupby(["line", "mesh"], sort=False)["error"].agg(["median", "max"])
    errors.columns = pd.Index(["median_error", "worst_error"])
    runs = of_part("disc_runs")(result).merge(errors.reset_index(), on=["line", "mesh"])
    return runs[runs["line"] != _REFERENCE]


def backend_differences(result: StudyResult) -> pd.DataFrame:
    """Differences between the graded meshes of both backends, mesh by mesh."""
    frame = of_part("disc_frequencies")(result)
    graded = [own for line, own in _by_line(frame) if "graded" in line]
    rows = []
    for fe, iga in zip(*(own.groupby("mesh", sort=False) for own in graded), strict=True):
        difference = np.abs(fe[1]["frequency"].to_numpy() / iga[1]["frequency"].to_numpy() - 1)
        worst, median = float(difference.max()), float(np.median(difference))
        rows.append({"fe": fe[0], "iga": iga[0], "median": median, "worst": worst})
    return pd.DataFrame(rows)


def _by_line(frame: pd.DataFrame) -> Any:
    return frame.groupby("line", sort=False) if len(frame) else []


def patch_headline(result: StudyResult) -> str | None:
    """The range of oscillations, and the worst ratio to what was expected."""
    frame = of_part("patch_test")(result)
    if frame.empty:
        return None
    least, most = (number(f(frame["oscillation"])) for f in (min, max))
    ratios = frame["ratio"].dropna()
    worst = max(ratios, key=lambda ratio: max(ratio, 1 / ratio), default=None)
    beside = f"; at worst {number(worst, 4)} times what was expected" if worst else ""
    return f"In the patch test σₙ oscillates by {least} to {most} N/m²{beside}."


def pad_headline(result: StudyResult) -> str | None:
    """How many unstable modes both backends find with GPTS, and how far they are apart."""
    frame = agreement(result)
    frame = frame[frame["formulation"] == "GPTS"] if len(frame) else frame
    if frame.empty:
        return None
    both = frame[frame["found_by"] == "both"]
    f, g = (both[f"{key}_difference"].abs().max() for key in ("frequency", "growth"))
    return (
        f"With GPTS both backends find {len(both)} unstable modes, at most {number(100 * f, 2)} % "
        f"apart in frequency and {number(100 * g, 2)} % in growth rate; {len(frame) - len(both)} "
        "have no partner."
    )


def disc_headline(result: StudyResult) -> str | None:
    """The most accurate mesh of each backend."""
    frame = disc_alone(result)
    if frame.empty:
        return None
    best = frame.loc[frame.groupby("backend", sort=False)["worst_error"].idxmin()]
    told = [
        f"{number(row['worst_error'], 2)} in {number(row['seconds'], 2)} s ({row['line']})"
        for row in best.to_dict("records")
    ]
    return f"The worst error of the frequencies of the disc alone is at best {' and '.join(told)}."


OWN = {
    "kind": Column("formulation"),
    "oscillation_a": Column("side a", "N/m²", shown(3)),
    "oscillation_b": Column("side b", "N/m²", shown(3)),
    "oscillation": Column("worse", "N/m²", shown(4)),
    "expected": Column("expected", "N/m²", shown(4)),
    "ratio": Column("worse / expected", show=shown(4)),
    "arc": Column("along the diagonal", "m", shown(3)),
    "sigma_n": Column("σₙ", "N/m²", shown(4)),
    "frequency_fe": Column("f, FE", "Hz", decimals(2)),
    "frequency_iga": Column("f, NURBS", "Hz", decimals(2)),
    "frequency_difference": Column("Δf", "%", per_cent),
    "growth_fe": Column("growth, FE", "1/s", decimals(2, sign=True)),
    "growth_iga": Column("growth, NURBS", "1/s", decimals(2, sign=True)),
    "growth_difference": Column("Δ growth", "%", per_cent),
    "modal_assurance": Column("MAC", show=decimals(4)),
    "found_by": Column("found by"),
    "line": Column("method"),
    "median_error": Column("median error", show=shown(2)),
    "worst_error": Column("worst error", show=shown(2)),
    "median": Column("median difference", show=shown(2)),
    "worst": Column("worst difference", show=shown(2)),
    "fe": Column("hexahedra"),
    "iga": Column("NURBS"),
}


def softest(result: StudyResult) -> pd.DataFrame:
    """Normal stress along the diagonal at the least P, a panel for each run."""
    frame = of_part("patch_stresses")(result)
    if frame.empty:
        return frame
    frame = frame[frame["P"] == frame["P"].min()]
    return frame.assign(panel=frame["backend"].map(backend_name) + ", " + frame["formulation"])


SECTIONS = [
    Section(
        "Disc and pad",
        "Modes of the disc and pad on both backends; unstable ones are paired by shape and "
        "frequency over all modes together. Differences are those of finite elements relative to "
        "NURBS; MAC is the modal assurance of both shapes on the contact surfaces.",
        pad_headline,
        [
            Table("agreement", "Unstable modes.", agreement, OWN, "formulation", printed=True),
            Table("unstable_modes", "Unstable modes of every run.", unstable, OWN),
            Table("windows", "What was searched, and the largest errors.", of_part("windows"), OWN),
            Table("eigenvalues", "", of_part("eigenvalues"), shown=False),
        ],
        [
            Plot(
                *("stability", "Every mode of every run.", of_part("eigenvalues")),
                *("frequency", "growth", ("formulation", "backend")),
                style="markers",
            )
        ],
        modes=True,
    ),
    Section(
        "Patch test",
        "Oscillation of σₙ, largest minus smallest over the contact surface of a side; exact is a "
        "uniform −1000 N/m². Expected is that of an independent prototype, where it was run.",
        patch_headline,
        [
            Table("patch_test", "Oscillation.", of_part("patch_test"), OWN, printed=True),
            Table("patch_stresses", "", of_part("patch_stresses"), shown=False),
        ],
        [
            Plot(
                *("patch_stresses", "σₙ at the least P.", softest, "arc", "sigma_n"),
                *(("side",), "panel"),
                own=OWN,
            )
        ],
    ),
    Section(
        "Disc alone",
        f"Errors |f / f_ref − 1| of the first {_MODES} frequencies of the disc without pad; the "
        "reference is NURBS of degree 4 graded to the clamped corners.",
        disc_headline,
        [
            Table("disc_alone", "Errors against run time.", disc_alone, OWN, printed=True),
            Table(
                *("backend_differences", "Differences between graded meshes of both backends."),
                backend_differences,
                OWN,
            ),
            Table("disc_frequencies", "", disc_frequencies, shown=False),
        ],
        [
            Plot(
                *(f"disc_errors_{x}", "Worst error of every mesh.", disc_alone, x, "worst_error"),
                *(("line",), "", "xy", OWN),
            )
            for x in ("seconds", "dofs")
        ],
    ),
]
STUDY = Study(
    name="agreement",
    title="Both backends on the same scenes",
    options=Options,
    cases=cases,
    scene=scene,
    evaluate=evaluate,
    quick={
        "gauss": (3,),
        "disc_meshes": 1,
        "reference": (6, 16, 5),
        "overrides": (
            "bodies.pad.mesh.fe.elements=[2, 3, 1]",
            "bodies.pad.mesh.iga.elements=[2, 3, 1]",
            "bodies.disc.mesh.fe.elements=[5, 24, 1]",
            "bodies.disc.mesh.iga.elements=[6, 28, 1]",
            "analysis.max_frequency=8500.0",
        ),
    },
    sections=SECTIONS,
)
