"""All modes of a window of matrices from files, by this program and by scipy.

scipy computes the eigenvalues nearest to five shifts on the imaginary axis of the window (ARPACK,
SuperLU). It gives no evidence that there are no others in between.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import pandas as pd
from scipy.sparse import csc_array
from scipy.sparse.linalg import ArpackError, LinearOperator, eigs, splu

from cea.arrays import Complexes
from cea.errors import require
from comparisons.study.columns import medians
from comparisons.study.measure import measured
from comparisons.study.numbers import shown
from comparisons.study.sections import Column, Section, Table
from comparisons.study.study import Case, Process, Session, Study, StudyResult, at_least_one
from scenes import Result
from scenes.running.matrices import AssembledMatrices
from scenes.spec.matrices import MatrixScene, load_matrices

_SHIFTS = 5  # shifts of scipy
_WANTED = 20  # eigenvalues at each shift
_SAME = 1e-6  # relative distance up to which two eigenvalues are the same


@dataclass(frozen=True)
class Options:
    """Options of the benchmark."""

    scene: Annotated[str, "Scene of matrices with damping: TOML file or name."] = "tu_berlin"
    set: Annotated[tuple[str, ...], "Fields of the scene to change."] = ()
    data: Annotated[str | None, "Folder of the matrix files."] = None
    repeats: Annotated[int, "Runs of each method; medians are reported."] = 3

    def __post_init__(self) -> None:
        at_least_one(repeats=self.repeats)


def loaded(options: Options) -> MatrixScene:
    """Return the scene; a scene without damping is refused."""
    scene = load_matrices(options.scene, options.set, options.data)
    allowed = "one matrix or more: the benchmark is for quadratic problems"
    require(bool(scene.damping), "damping", {}, allowed)
    return scene


def cases(options: Options) -> Iterator[Case]:
    """Every method in rounds, labelled with a digest of the matrix files."""
    scene = loaded(options)
    files = (Path(scene.data, name.partition(":")[0]) for name in scene.files.values())
    digest = sha256(b"".join(file.read_bytes() for file in files if file.is_file())).hexdigest()
    for repeat in range(options.repeats):
        for way in WAYS:
            yield {"files": digest[:12], "way": way, "repeat": repeat}


@cache
def _first(options: Options) -> tuple[AssembledMatrices, Result]:
    """Return the matrices of the scene and its modes, computed once in a process."""
    assembled = AssembledMatrices(loaded(options))
    return assembled, assembled.modes()


def evaluate(case: Case, session: Session) -> dict[str, Any]:
    """Return times of a method, and how many modes of this program it finds."""
    assembled, first = _first(session.options)
    assembled.free()
    with measured() as cost:
        values = WAYS[case["way"]](assembled, first.matrices())
    apart = np.abs(first.eigenvalues[:, None] - values)
    found = int((apart.min(axis=1) <= _SAME * np.abs(first.eigenvalues)).sum())
    of = len(first.eigenvalues)
    return {"clock": cost.clock, "processor": cost.processor, "found": found, "modes": of}


def nearest(assembled: AssembledMatrices, matrices: Mapping[str, Any]) -> Complexes:
    """Return the eigenvalues nearest to shifts at the midpoints of equal parts of the window."""
    top = 2 * np.pi * assembled.scene.window.max_frequency
    found = []
    for shift in 1j * top * (np.arange(_SHIFTS) + 0.5) / _SHIFTS:
        try:
            found.append(_reduced(matrices, shift))
        except ArpackError as error:
            found.append(np.asarray(getattr(error, "eigenvalues", []), dtype=complex))
    return np.concatenate(found)


def _reduced(matrices: Mapping[str, Any], shift: complex) -> Complexes:
    """Return the eigenvalues nearest to a shift, by the companion form with factors of Q(shift)."""
    M, C, K = (matrices[name] for name in "MCK")
    n = M.shape[0]
    factors, rest = splu(csc_array(shift**2 * M + shift * C + K)), csc_array(shift * M + C)

    def inverse(z: Complexes) -> Complexes:
        x, velocity = z[:n], z[n:]
        moved = factors.solve(-(M @ velocity + rest @ x))
        return np.concatenate([moved, x + shift * moved])

    operator = LinearOperator((2 * n, 2 * n), matvec=inverse, dtype=complex)
    return shift + 1 / eigs(operator, _WANTED, return_eigenvectors=False)


WAYS: Mapping[str, Callable[[AssembledMatrices, Mapping[str, Any]], Complexes]] = {
    "cea, the whole window": lambda assembled, _: assembled.modes().eigenvalues,
    f"scipy, {_SHIFTS} shifts, Q(sigma) factorised": nearest,
}


def seconds(result: StudyResult) -> pd.DataFrame:
    """Medians of each method, and its processor time over that of this program."""
    found = medians(result.frame())
    ours = found["processor"][found["way"] == next(iter(WAYS))]
    return found.drop(columns="files").assign(relative=found["processor"] / ours.iloc[0])


OWN = {"relative": Column("of ours", show=shown(3))}
TABLE = Table("race", "Medians of runs in one process.", seconds, OWN, printed=True)
STUDY = Study(
    name="bench matrices",
    title="All modes of a window, compared with shift-invert by scipy",
    options=Options,
    cases=cases,
    evaluate=evaluate,
    process=Process("comparisons.bench.matrices:STUDY", 3600.0),
    sections=[Section("Seconds", tables=[TABLE], of="runs")],
)
