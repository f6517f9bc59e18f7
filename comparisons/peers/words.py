"""What both programs found, in sentences made of the data."""

from comparisons.kit.numbers import counted, number
from comparisons.kit.tables import Data
from comparisons.peers.tables import apart


def summary(data: Data) -> str:
    """The finding in short."""
    alone = [p for p in data["problems"] if not p["contact"]]
    touching = [p for p in data["problems"] if p["contact"]]
    modes = min(len(p["modes"]) for p in alone)
    return (
        f"CalculiX {data['calculix']} and this program on the same meshes. Each body alone: the "
        f"first {modes} frequencies differ by {number(max(map(apart, alone)), 2)} at most, "
        "relative to the frequency. Both in frictional contact: by "
        f"{number(max(map(apart, touching)), 2)}, {unstable_modes(touching)}. {ratio(touching)}"
    )


def unstable_modes(problems: list[Data]) -> str:
    """Whether the same modes are unstable, and how far their growth rates are apart."""
    counts, farthest = True, 0.0
    for problem in problems:
        theirs, ours = (problem["unstable"][name] for name in ("CalculiX", "this program"))
        counts = counts and len(theirs) == len(ours)
        for a, b in zip(theirs, ours, strict=False):
            farthest = max(farthest, abs(b["growth"] / a["growth"] - 1))
    if not counts:
        return "and they find different numbers of unstable modes"
    total = sum(len(problem["unstable"]["CalculiX"]) for problem in problems)
    if not total:
        return "and no mode is unstable"
    return (
        f"and both find {counted(total, 'unstable mode')}, whose growth rates differ by "
        f"{number(farthest, 2)} at most"
    )


def ratio(problems: list[Data]) -> str:
    """Processor time of the largest problem."""
    largest = max(problems, key=lambda problem: problem["dofs"])
    theirs, ours = largest["runs"]
    return (
        f"With {counted(largest['dofs'], 'dof')} in contact CalculiX takes "
        f"{number(theirs['processor'], 3)} s of the processor and {number(theirs['memory'] / 1e6)} "
        f"MB, this program {number(ours['processor'], 3)} s and {number(ours['memory'] / 1e6)} MB, "
        "start-up included."
    )


def mass(data: Data) -> str:
    """What the quadrature of the mass does."""
    alone = [p for p in data["problems"] if not p["contact"]]
    worst = max(apart(problem, "exact_mass") for problem in alone)
    return (
        "CalculiX integrates the mass of a tetrahedron of ten nodes with the four points of its "
        "stiffness, exact to degree 2 where products of shape functions have degree 4. With the "
        "same points in this program the frequencies agree to rounding; with the exact mass, as "
        f"this program has it otherwise, they are up to {number(worst, 2)} lower, less on finer "
        "meshes: both converge to the same."
    )


def contact(data: Data) -> str:
    """Why what is left differs in contact."""
    areas = [p["area"]["meshed"] / p["area"]["CalculiX"] - 1 for p in data["problems"] if p["area"]]
    left_out = f"{number(max(areas), 2)} of the area" if areas else "a part of the area"
    return (
        "Both integrate the penalty over pieces that no element boundary of either side crosses. "
        f"CalculiX leaves out the smallest of them, up to {left_out}. Across the direction of slip "
        "it gives points their stick stiffness, for which the deck takes 1e-5 of the contact "
        "stiffness, and its mesh has slid a little. Complex eigenvalues are printed with seven "
        "digits."
    )


STICKING = (
    "CalculiX knows no steady sliding: it takes a point to slip where its friction of the static "
    "step is beyond the limit in the frequency step. With the same friction in both steps that is "
    "decided by rounding, many points stick, and modes that are unstable come out stable. The deck "
    "has twice the friction in the static step, and changes it to that of the scene in the "
    "frequency step, where then every point slips."
)
"""How friction is made to act everywhere."""
