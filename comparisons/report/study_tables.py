"""Tables of the studies of contact formulations."""

from comparisons.report.numbers import backend_name, listed, number, shown
from comparisons.report.tables import Data
from comparisons.report.tabular import Column, Table


def locking_table(data: Data) -> Table:
    """Worst error of the lowest eigenvalues for each p."""
    top = number(data["study"]["max_frequency"], 2)
    return Table(
        "locking",
        f"Worst relative error of the eigenvalues of the blocks up to Im λ = {top}, for contact "
        "stiffnesses p. A formulation locks where its error grows with p; a dash stands where an "
        "eigenvalue was lost altogether, or p = ∞ cannot be run.",
        (
            Column("backend", "backend", backend_name),
            Column("formulation", "formulation"),
            Column("points", "points", number),
            Column("traces", "traces of a", number),
            *(Column(f"error_p_{p:g}", f"p = {number(p, 1)}", shown(2)) for p in data["p"]),
            Column("error_tied", "p = ∞", shown(2)),
        ),
        [
            (
                *(run[key] for key in ("backend", "formulation", "points", "traces")),
                *run["errors"],
                run["tied_error"],
            )
            for run in data["runs"]
        ],
    )


def patch_tests_table(data: Data) -> Table:
    """Errors of every patch test, where it is passed, and the momentum lost."""
    momentum = [(kind, part) for kind in ("normal", "friction") for part in ("linear", "angular")]
    return Table(
        "patch_tests",
        "Contact patch tests: largest error of σₙ relative to the exact pressure, over both sides, "
        f"for each P (N/m). Passed where it is below {number(data['passed'], 1)}, or of the size "
        "of the error that both bodies have without contact (“own”). Momentum: resultant force and "
        "moment of contact forces on both bodies together, relative; where meshes of a curved "
        "interface leave gaps, friction has a moment.",
        (
            Column("interface", "interface"),
            Column("meshes", "a on b"),
            Column("formulation", "formulation"),
            Column("points", "points", number),
            *(Column(f"error_P_{P:g}", f"P = {number(P, 1)}", shown(1)) for P in data["P"]),
            Column("own_error", "own", shown(1)),
            Column("passes", "passes for P"),
            *(Column(f"{k}_{part}", f"{part}, {k}", shown(1)) for k, part in momentum),
        ),
        [
            (
                run["interface"],
                " on ".join(run["meshes"]),
                run["formulation"],
                run["points"],
                *run["errors"],
                run["own_error"],
                _passes(run["passes"], data["P"]),
                *(run["momentum"][kind][part] for kind, part in momentum),
            )
            for run in data["runs"]
        ],
    )


def _passes(passed: list[float], every: list[float]) -> str:
    """The P of a test that is passed, in words."""
    if not passed:
        return "none"
    if passed == every:
        return "every"
    if len(passed) > 1 and passed == every[every.index(passed[0]) :]:
        return f"{number(passed[0], 1)} and more"
    return listed(number(P, 1) for P in passed)
