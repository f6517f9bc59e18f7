"""Locking: error of the lowest eigenvalues of the `blocks` problem as contact grows stiff.

A penalty at more points than the traces of side a can follow leaves the interface, as p grows, no
motion but what both meshes share: it locks. Mortar asks as many conditions as side a has traces.
Two layers slide on each other with meshes of 12 against 13 elements; exact eigenvalues are known
for any p (:mod:`exact_cea`).
"""

from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, replace
from math import inf, isfinite, tau
from pathlib import Path
from typing import Any

from cea.arrays import Complexes
from cea.eigen.eigenvalue_matching import match_spectrum
from cea.timing import StageTimer
from comparisons.formulations.timings import summed
from comparisons.formulations.variants import Variant, variants
from comparisons.kit.progress import Progress
from exact_cea.reference import exact_eigenvalues
from scenes.build import build_bodies
from scenes.read import Scene, load_scene
from scenes.run import run_modes
from scenes.spec.analysis import ComplexEigenvalueAnalysis
from scenes.spec.body import Backend
from scenes.spec.mesh import FeMesh, IgaMesh, MeshSpec
from scenes.variants import BACKENDS, on_backend

_MARGIN = 1.15
"""How far beyond the exact eigenvalues is searched: locked ones lie too high."""


@dataclass(frozen=True)
class LockingStudy:
    """Meshes, stiffnesses and formulations of the study.

    Parameters
    ----------
    stiffnesses
        Contact stiffnesses p; body a has E = 0.1 and thickness 0.5.
    mu0
        Amplitude of the friction coefficient mu0 sin(pi x / 2).
    max_frequency
        Highest Im lambda of the exact eigenvalues that are looked at: six lie below 2.2.
    elements_a, elements_b
        Elements along x and y.
    degree
        Degree on both sides, splines with continuity degree - 1.
    gauss
        GPTS points per element; lumped and in a full pass too.
    grid
        Equally spaced points over side a.
    tied
        Whether p = infinity is run too, in the saddle form.
    only
        Labels of formulations (:mod:`comparisons.formulations.variants`); empty takes all.
    backends
        Backends, both sides on the same.
    """

    stiffnesses: tuple[float, ...] = tuple(float(10**k) for k in range(10))
    mu0: float = 0.3
    max_frequency: float = 2.2
    elements_a: tuple[int, int] = (12, 4)
    elements_b: tuple[int, int] = (13, 8)
    degree: int = 2
    gauss: tuple[int, ...] = (3, 6)
    grid: int = 37
    tied: bool = True
    only: tuple[str, ...] = ()
    backends: tuple[Backend, ...] = BACKENDS

    def scene(self, backend: Backend) -> Scene:
        """The `blocks` scene on the meshes of the study."""
        overrides = [f"contacts.interface.mu={self.mu0!r}*sin(pi*x/2)"]
        scene = on_backend(load_scene(Path("blocks"), overrides), backend)
        upper, lower = (
            replace(scene.bodies[name], mesh=self._mesh(elements))
            for name, elements in (("upper", self.elements_a), ("lower", self.elements_b))
        )
        return replace(scene, bodies={"upper": upper, "lower": lower})

    def variants(self, backend: Backend) -> tuple[Variant, ...]:
        """Formulations on a backend, with about as many grid points over side a on either."""
        grid = self.grid
        if backend == "fe":
            grid = 1 + max(1, round((self.grid - 1) / self.elements_a[0]))
        every = variants((backend, backend), gauss=self.gauss, grid=grid)
        return tuple(v for v in every if not self.only or v.label in self.only)

    def _mesh(self, elements: tuple[int, int]) -> MeshSpec:
        return MeshSpec(
            fe=FeMesh("quadrilateral", self.degree, elements=elements),
            iga=IgaMesh((self.degree, self.degree), elements),
        )


DEFAULT = LockingStudy()


def run_locking(progress: Progress, study: LockingStudy = DEFAULT) -> dict[str, Any]:
    """Error of the lowest eigenvalues against p for every formulation.

    Returns
    -------
    dict
        Plain data: ``study``; ``p``; ``exact``, eigenvalues as [re, im] for each p; ``runs`` with
        ``backend``, ``formulation``, ``points`` of the rule, ``traces`` (scalar dofs of side a on
        the interface), ``errors``, for each p the worst of abs(lambda_h - lambda) / abs(lambda),
        None where one is more than 15 per cent off, and ``tied_error``, the same for p = infinity,
        None too where that was not run; ``timings`` over all runs.
    """
    stiffnesses = (*study.stiffnesses, inf) if study.tied else study.stiffnesses
    exact = {}
    for p in stiffnesses:
        progress.step(f"locking, exact eigenvalues, p = {p:g}")
        exact[p] = exact_eigenvalues("blocks", p=p, mu=study.mu0, max_frequency=study.max_frequency)
    timings: list[Mapping[str, float]] = []
    runs = [
        run for backend in study.backends for run in _runs(progress, timings, study, backend, exact)
    ]
    return {
        "study": asdict(study),
        "p": list(study.stiffnesses),
        "exact": [[[v.real, v.imag] for v in exact[p].tolist()] for p in study.stiffnesses],
        "runs": runs,
        "timings": summed(timings),
    }


def _runs(
    progress: Progress,
    timings: list[Mapping[str, float]],
    study: LockingStudy,
    backend: Backend,
    exact: Mapping[float, Complexes],
) -> Iterator[dict[str, Any]]:
    top = _MARGIN * study.max_frequency / tau
    scene = replace(study.scene(backend), analysis=ComplexEigenvalueAnalysis("cea", top))
    meshing = StageTimer(progress.stage)
    bodies = build_bodies(scene, meshing)
    timings.append(meshing.seconds)
    for variant in study.variants(backend):
        errors: dict[float, float | None] = {}
        for p, values in exact.items():
            if p == inf and not variant.has_saddle_form:
                continue
            progress.step(f"locking, {backend}, {variant.label}, p = {p:g}")
            result = run_modes(variant.of(scene, p=p), bodies=bodies, listener=progress.stage)
            timings.append(result.timer.seconds)
            match = match_spectrum(result.eigenvalues, values, reach=_MARGIN - 1)
            worst = float(match.errors.max())
            errors[p] = worst if isfinite(worst) else None
        a = result.interfaces["interface"].a
        yield {
            "backend": backend,
            "formulation": variant.label,
            "points": sum(len(interface.points) for interface in result.interfaces.values()),
            "traces": len(a.abscissae(a.abscissa_kinds[0])),
            "errors": [errors[p] for p in study.stiffnesses],
            "tied_error": errors.get(inf),
        }
