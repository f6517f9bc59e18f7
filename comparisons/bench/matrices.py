"""All modes of a window of matrices from files, beside runs of shift-and-invert by scipy.

What a person would do without this program: at five shifts along the imaginary axis of the window
the nearest eigenvalues by ARPACK and SuperLU, with no word on what lies between them.
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

_SHIFTS = 5  # runs of scipy
_WANTED = 20  # eigenvalues of each
_SAME = 1e-6  # relative distance of eigenvalues that are the same


@dataclass(frozen=True)
class Options:
    """Options of the benchmark."""

    scene: Annotated[str, "Scene of matrices with damping: TOML file, or its name."] = "tu_berlin"
    set: Annotated[tuple[str, ...], "Override of a field of the scene."] = ()
    data: Annotated[str | None, "Folder of the files that it names."] = None
    repeats: Annotated[int, "Runs of each by turns; medians count."] = 3

    def __post_init__(self) -> None:
        at_least_one(repeats=self.repeats)


def loaded(options: Options) -> MatrixScene:
    """The scene, refused without damping."""
    scene = load_matrices(options.scene, options.set, options.data)
    allowed = "one matrix or more: the race is one of quadratic problems"
    require(bool(scene.damping), "damping", {}, allowed)
    return scene


def cases(options: Options) -> Iterator[Case]:
    """Every way by turns; labelled with a digest of the files, whose numbers decide."""
    scene = loaded(options)
    files = (Path(scene.data, name.partition(":")[0]) for name in scene.files.values())
    digest = sha256(b"".join(file.read_bytes() for file in files if file.is_file())).hexdigest()
    for repeat in range(options.repeats):
        for way in WAYS:
            yield {"files": digest[:12], "way": way, "repeat": repeat}


@cache
def _first(options: Options) -> tuple[AssembledMatrices, Result]:
    """The scene as read, and its modes, once in a process."""
    assembled = AssembledMatrices(loaded(options))
    return assembled, assembled.modes()


def evaluate(case: Case, session: Session) -> dict[str, Any]:
    """Seconds of a way, and how many of the modes of this program it finds."""
    assembled, first = _first(session.options)
    assembled.free()
    with measured() as cost:
        values = WAYS[case["way"]](assembled, first.matrices())
    apart = np.abs(first.eigenvalues[:, None] - values)
    found = int((apart.min(axis=1) <= _SAME * np.abs(first.eigenvalues)).sum())
    of = len(first.eigenvalues)
    return {"clock": cost.clock, "processor": cost.processor, "found": found, "modes": of}


def nearest(assembled: AssembledMatrices, matrices: Mapping[str, Any]) -> Complexes:
    """Eigenvalues nearest to shifts in the middle of equal parts of the window."""
    top = 2 * np.pi * assembled.scene.window.max_frequency
    found = []
    for shift in 1j * top * (np.arange(_SHIFTS) + 0.5) / _SHIFTS:
        try:
            found.append(_reduced(matrices, shift))
        except ArpackError as error:
            found.append(np.asarray(getattr(error, "eigenvalues", []), dtype=complex))
    return np.concatenate(found)


def _reduced(matrices: Mapping[str, Any], shift: complex) -> Complexes:
    """Eigenvalues nearest to a shift by the companion form, its systems reduced to Q(shift)."""
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
    """Medians of each way, and its processor time over that of this program."""
    found = medians(result.frame())
    ours = found["processor"][found["way"] == next(iter(WAYS))]
    return found.drop(columns="files").assign(relative=found["processor"] / ours.iloc[0])


OWN = {"relative": Column("of ours", show=shown(3))}
TABLE = Table("race", "Medians of runs by turns in one process.", seconds, OWN, printed=True)
STUDY = Study(
    name="bench matrices",
    title="All modes of a window beside shift-and-invert by scipy",
    options=Options,
    cases=cases,
    evaluate=evaluate,
    process=Process("comparisons.bench.matrices:STUDY", 3600.0),
    sections=[Section("Seconds", tables=[TABLE], of="runs")],
)
