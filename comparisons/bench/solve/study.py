"""Eigenvalues of one window by several methods: time, memory, error.

The matrices are assembled once and kept in files. Each method reads them in a process of its own,
so that its memory is its own, and there counts its seconds in numeric factorisations (LU) at the
shift that all of them use: how fast the machine happens to be then cancels.
"""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import Any

import numpy as np
from scipy.optimize import linear_sum_assignment

from cea.arrays import Complexes
from cea.eigen.classify import classify, thresholds
from cea.errors import ConvergenceError, InputError
from cea.petsc import MPI
from comparisons.bench.launch import asked
from comparisons.bench.solve.methods.problem import SIZES, scene_of_size, write_matrices
from comparisons.kit.progress import Progress
from scenes.results.record import record

COMMAND = "bench solve"
OURS = "this driver"
_PROCESS = "comparisons.bench.solve.process"
_GIGA = 10**9


@dataclass(frozen=True)
class Method:
    """A way to the eigenvalues.

    Parameters
    ----------
    name
        Its name in tables.
    module
        Its file in this folder's ``methods``.
    modes
        Real modes that it projects on; 0 where it does not.
    serial
        Whether it runs on one rank alone.
    """

    name: str
    module: str
    modes: int = 0
    serial: bool = False


METHODS = (
    Method(OURS, "this_driver"),
    Method("SLEPc Krylov-Schur", "slepc_krylov_schur"),
    Method("scipy eigs, SuperLU", "scipy_arpack", serial=True),
    *(Method(f"{count} real modes", "projection", count) for count in (100, 200, 300)),
)


@dataclass(frozen=True)
class SolveStudy:
    """What is run.

    Parameters
    ----------
    size
        Name of the mesh (:data:`~comparisons.bench.solve.methods.problem.SIZES`).
    ranks
        Ranks of each method; what runs on one alone is left out on more.
    repeats
        Runs of each by turns; medians count.
    seconds
        Longest time for a run by the clock.
    memory
        Most memory of each rank (10^9 bytes), as addresses: what asks for more fails.
    """

    size: str = "medium"
    ranks: int = 1
    repeats: int = 1
    seconds: float = 900.0
    memory: float = 8.0

    def __post_init__(self) -> None:
        for name in ("ranks", "repeats"):
            if getattr(self, name) < 1:
                raise InputError(name, getattr(self, name), "1 or more")
        for name in ("seconds", "memory"):
            if not getattr(self, name) > 0:
                raise InputError(name, getattr(self, name), "a positive number")
        if self.size not in SIZES:
            raise InputError("size", self.size, f"one of {', '.join(SIZES)}")


def run_solve(study: SolveStudy, progress: Progress) -> dict[str, Any]:
    """Run every method.

    Returns
    -------
    dict
        The record: ``unknowns``, and ``methods``, each with its ``name``, ``failed`` (the reason,
        or ""), lists of every repeat, ``processor``, ``clock``, ``lu`` (s), its ``peak`` memory
        and that ``before`` it began (bytes), ``counts`` and ``stages``, ``eigenvalues`` and
        ``backward_errors``, and ``errors`` of the eigenvalues that the tightest answer has,
        relative, in rising order; ``missing`` are those it has none for.

    Raises
    ------
    InputError
        On several ranks: the methods' processes start their own.
    """
    if MPI.COMM_WORLD.size > 1:
        raise InputError("mpiexec", MPI.COMM_WORLD.size, "--ranks instead")
    begun = perf_counter()
    taking_part = [each for each in METHODS if study.ranks == 1 or not each.serial]
    with TemporaryDirectory() as name:
        folder = Path(name)
        progress.step(f"matrices, {study.size}")
        unknowns = write_matrices(scene_of_size(study.size), folder)
        found: dict[str, list[dict[str, Any]]] = {each.name: [] for each in taking_part}
        failed: dict[str, str] = {}
        wanted = None
        for number in range(study.repeats):
            for method in taking_part:
                if method.name in failed:
                    continue
                progress.step(f"{method.name}, {number + 1} of {study.repeats}")
                try:
                    answer = _run(method, study, folder, wanted)
                except ConvergenceError as error:
                    failed[method.name] = str(error)
                    if method.name == OURS and wanted is None:
                        raise  # nobody else knows how many there are
                    continue
                found[method.name].append(answer)
                wanted = wanted or len(answer["eigenvalues"])
    methods = [_described(m, found[m.name], failed.get(m.name, "")) for m in taking_part]
    tightest = _with_errors(methods)
    left_out = [
        {"name": m.name, "reason": "runs on one rank"} for m in METHODS if m not in taking_part
    ]
    data = {"unknowns": unknowns, "methods": methods, "tightest": tightest, "left_out": left_out}
    return record(COMMAND, data, inputs=asdict(study), seconds=perf_counter() - begun)


def _run(method: Method, study: SolveStudy, folder: Path, wanted: int | None) -> dict[str, Any]:
    question = {
        "method": method.module,
        "modes": method.modes,
        "folder": str(folder),
        "wanted": wanted,
        "memory": int(study.memory * _GIGA),
    }
    return asked(_PROCESS, question, folder, ranks=study.ranks, seconds=study.seconds)


def _described(method: Method, answers: list[dict[str, Any]], failed: str) -> dict[str, Any]:
    last = answers[-1] if answers else {}
    lists = ("processor", "clock", "lu")
    kept = ("peak", "before", "counts", "stages", "claims", "eigenvalues", "backward_errors")
    return {
        "name": method.name,
        "failed": failed,
        **{name: [answer[name] for answer in answers] for name in lists},
        **{name: last.get(name) for name in kept},
    }


def _with_errors(methods: list[dict[str, Any]]) -> str:
    """Add the errors against the tightest answer; its name."""
    answered = [method for method in methods if not method["failed"]]
    tightest = min(answered, key=lambda method: max(method["backward_errors"]))
    exact = _complex(tightest["eigenvalues"])
    for method in answered:
        errors, missing = errors_of(_complex(method["eigenvalues"]), exact)
        method["errors"], method["missing"] = sorted(errors), missing
        method["unstable"] = unstable(_complex(method["eigenvalues"]))
    return str(tightest["name"])


def errors_of(found: Complexes, exact: Complexes) -> tuple[list[float], int]:
    """Relative errors of eigenvalues, each paired with an exact one, and how many have no pair."""
    cost = np.abs(found[:, None] - exact) / np.abs(exact)
    rows, columns = linear_sum_assignment(cost)
    return cost[rows, columns].tolist(), len(exact) - len(columns)


def unstable(kappa: Complexes) -> int:
    """How many modes grow."""
    speeds = np.sqrt(-kappa.astype(complex))
    speeds = np.where(speeds.imag < 0, -speeds, speeds)
    return classify(speeds.real, 0.0, thresholds(speeds), False).count("unstable")


def _complex(pairs: list[Mapping[int, float]] | Any) -> Complexes:
    return np.array([complex(*pair) for pair in pairs], dtype=complex)
