"""Tables of the report of a run, made of its record."""

from collections.abc import Iterable, Mapping
from math import hypot, tau
from typing import Any

from comparisons.kit import provenance
from comparisons.kit.interactive import sign
from comparisons.kit.numbers import growth, number, plain, shown
from comparisons.kit.tables import Column, Data, Table
from scenes.spec.names import backend_name


def modes(data: Data) -> Table:
    """Every mode with its verdict and errors."""
    rows = [
        (
            i + 1,
            sign(value["verdict"]),
            value["im"] / tau,
            value["re"],
            damping_ratio(value),
            value["uncertainty"],
            value["residual"],
            value["condition"],
        )
        for i, value in enumerate(data["eigenvalues"])
    ]
    return Table(
        "modes",
        "Every mode of the window by rising frequency. Damping ratio: minus the growth rate over "
        "abs(λ). Algebraic error: what residual and rounding, times the condition, can make of the "
        "growth rate; errors of the mesh are told by cea converge.",
        (
            Column("mode", "mode", number),
            Column("verdict", "verdict"),
            Column("frequency", "frequency", shown(6), "Hz"),
            Column("growth", "growth rate", growth, "1/s"),
            Column("damping_ratio", "damping ratio", shown(3, sign=True)),
            Column("uncertainty", "algebraic error", shown(2), "1/s"),
            Column("residual", "residual", shown(2)),
            Column("condition", "condition", shown(3)),
        ),
        rows,
    )


def damping_ratio(value: Mapping[str, Any]) -> float | None:
    """Minus the growth rate over abs(lambda); None of a mode that stands still."""
    size = hypot(value["re"], value["im"])
    return 0.0 - value["re"] / size if size else None


def bodies(data: Data) -> Table:
    """Bodies of the scene: how they are discretised, of what they are made, what holds them."""
    rows = []
    for name, body in data["scene"].get("bodies", {}).items():
        mesh = (body.get("mesh") or {}).get(body["backend"]) or {}
        material = body["material"]
        rows.append(
            (
                name,
                backend_name(body["backend"]),
                ", ".join(_mesh_words(mesh)),
                data["dofs"]["bodies"][name],
                material["E"],
                material["nu"],
                material.get("rho"),
                ", ".join(support["surface"] for support in body.get("supports") or ()) or "none",
            )
        )
    return Table(
        "bodies",
        "Bodies, their meshes and materials. Dofs are those that supports leave free.",
        (
            Column("body", "body"),
            Column("backend", "discretised by"),
            Column("mesh", "mesh"),
            Column("dofs", "dofs", number),
            Column("E", "E", shown(3), "N/m²"),
            Column("nu", "ν", shown(3)),
            Column("rho", "ρ", shown(4), "kg/m³"),
            Column("supports", "supported at"),
        ),
        rows,
    )


def _mesh_words(mesh: Mapping[str, Any]) -> Iterable[str]:
    if cell := mesh.get("cell"):
        yield cell
    if (degree := mesh.get("degree")) is not None:
        degrees = degree if isinstance(degree, list | tuple) else [degree]
        yield f"degree {plain(degrees[0] if len(set(degrees)) == 1 else list(degrees))}"
    if elements := mesh.get("elements"):
        yield " × ".join(map(str, elements))
    if size := mesh.get("size"):
        yield f"size {plain(float(size))} m"


def contacts(data: Data) -> Table:
    """Contact points of each half pass, and what was asked of the contact."""
    specs = data["scene"].get("contacts", {})
    rows = []
    for name, found in data["contacts"].items():
        spec = specs.get(name) or specs.get(name.rpartition(".")[0]) or {}
        stiffness = next((f"{k} = {plain(spec[k])}" for k in ("P", "p", "c_n") if spec.get(k)), "")
        rows.append(
            (
                name,
                f"{spec.get('a', '')} on {spec.get('b', '')}" if spec else "",
                (spec.get("formulation") or {}).get("method", ""),
                stiffness,
                plain(spec.get("mu", "")),
                found["points"],
                found["status"].get("missed", 0),
                found["area"],
                found["largest_distance"],
            )
        )
    return Table(
        "contacts",
        "Contact points as they were found on the other side.",
        (
            Column("contact", "contact"),
            Column("sides", "sides"),
            Column("formulation", "formulation"),
            Column("stiffness", "stiffness"),
            Column("mu", "μ"),
            Column("points", "points", number),
            Column("missed", "missed", number),
            Column("area", "area of side a", shown(4), "m²"),
            Column("largest_distance", "largest gap", shown(2), "m"),
        ),
        rows,
    )


def skipped(data: Data) -> Table:
    """What the scene did not need, with the reason."""
    return Table(
        "skipped",
        "What was left out because the scene does not need it.",
        (Column("left_out", "left out"), Column("reason", "reason")),
        list(data["skipped"].items()),
    )


def parameters(data: Data) -> Table:
    """Parameters of the scene as run."""
    made = provenance.parameters([("scene", "run", data)])
    rows = [row[1:] for row in made.rows]
    return Table("parameters", "Parameters of the scene as run.", made.columns[1:], rows)
