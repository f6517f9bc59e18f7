"""Tables of the studies of contact formulations; those of pairings are a module of their own."""

from collections.abc import Iterable

from cea.timing import STAGES
from comparisons.kit.numbers import decimals, listed, number, plain, shown
from comparisons.kit.tables import VERDICTS, Column, Data, Table
from scenes.names import backend_name

PARTS = {
    "patch_tests": "patch tests and momentum",
    "locking": "locking",
    "paper": "numbers of the paper",
    "pairings": "pairings of backends",
}
"""Parts of the data by the name shown."""


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
                passes_in_words(run["passes"], data["P"]),
                *(run["momentum"][kind][part] for kind, part in momentum),
            )
            for run in data["runs"]
        ],
    )


def passes_in_words(passed: list[float], every: list[float]) -> str:
    """The P of a test that is passed, in words."""
    if not passed:
        return "none"
    if passed == every:
        return "every"
    if len(passed) > 1 and passed == every[every.index(passed[0]) :]:
        return f"{number(passed[0], 1)} and more"
    return listed(number(P, 1) for P in passed)


def passes_table(data: Data, interface: str) -> Table:
    """The P for which each formulation passes the patch test of an interface, by meshes."""
    runs = [run for run in data["runs"] if run["interface"] == interface]
    meshes = list(dict.fromkeys(" on ".join(run["meshes"]) for run in runs))
    passed: dict[str, dict[str, str]] = {}
    for run in runs:
        row = passed.setdefault(run["formulation"], {})
        row[" on ".join(run["meshes"])] = passes_in_words(run["passes"], data["P"])
    return Table(
        f"passes_{interface}",
        f"Interface: {interface}. P (N/m) for which each formulation passes, by meshes of sides a "
        f"and b, out of {listed(number(P, 1) for P in data['P'])}; a dash where it is not offered.",
        (Column("formulation", "formulation"), *(Column(name, name) for name in meshes)),
        [(name, *(row.get(m) for m in meshes)) for name, row in passed.items()],
    )


def momentum_table(data: Data) -> Table:
    """Largest loss of momentum of each formulation on each interface, over all meshes."""
    kinds = [(kind, part) for part in ("linear", "angular") for kind in ("normal", "friction")]
    worst: dict[tuple[str, str], dict[tuple[str, str], float]] = {}
    for run in data["runs"]:
        row = worst.setdefault((f"interface: {run['interface']}", run["formulation"]), {})
        for kind, part in kinds:
            row[kind, part] = max(row.get((kind, part), 0.0), run["momentum"][kind][part])
    return Table(
        "momentum",
        "Resultant force (linear) and moment (angular) of contact forces on both bodies together, "
        "relative to the largest that they could have: the largest over all meshes. Where meshes "
        "of a curved interface leave gaps, friction has a moment.",
        (
            Column("section", "interface"),
            Column("formulation", "formulation"),
            *(Column(f"{part}_{kind}", f"{part}, {kind}", shown(1)) for kind, part in kinds),
        ),
        [(*key, *(row[k] for k in kinds)) for key, row in worst.items()],
    )


def paper_numbers(data: Data) -> Table:
    """Numbers of the paper beside ours, with a verdict."""
    part = data["paper"]
    return Table(
        "paper_numbers",
        f"Numbers of the paper beside ours. Met: within {plain(100 * part['within'])} % of the "
        "paper's, or as its words have it; a dash where it says nothing that can be judged.",
        (
            Column("section", "figure"),
            Column("what", "what"),
            Column(
                "paper", "paper", lambda value: value if isinstance(value, str) else f"{value:g}"
            ),
            Column("ours", "ours", number),
            Column("ratio", "ours / paper", shown(3)),
            Column("unit", "unit"),
            Column("met", "met", VERDICTS.__getitem__),
            Column("remark", "remark"),
        ),
        [
            (
                *(figure["title"], n["what"], n["paper"], n["ours"], _ratio(n)),
                *(n["unit"], n["met"], n["remark"]),
            )
            for figure in part["figures"]
            for n in figure["numbers"]
        ],
    )


def _ratio(row: Data) -> float | None:
    """Ours over the paper's, where that is a number other than zero."""
    paper = row["paper"]
    return None if isinstance(paper, str) or not paper else row["ours"] / paper


def times(data: Data) -> Table:
    """Run time of every part, by stage where its runs tell."""
    rows = [(name, *_stages(data[key]), data[key]["seconds"]) for key, name in PARTS.items()]
    seconds = decimals(2)
    return Table(
        "study_times",
        "Seconds of each part by stage of its runs, and in all: the rest went into exact "
        "eigenvalues, stresses, momentum and matching. A dash where a part does not tell stages.",
        (
            Column("part", "part"),
            *(Column(stage, stage, seconds, "s") for stage in STAGES),
            Column("total", "in all", seconds, "s"),
        ),
        rows,
    )


def _stages(part: Data) -> Iterable[float | None]:
    if "timings" not in part:
        return [None] * len(STAGES)
    return [part["timings"].get(stage, 0.0) for stage in STAGES]
