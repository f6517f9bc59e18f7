"""Unstable modes of the disc and pad in every pairing of backends, beside each other.

With mortar contact only the bodies' own discretisation is left to differ. The last pairing is run
once more with a higher degree on the same elements: what changes there is not converged, however
well the pairings agree.
"""

from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from cea.contact.formulations import Mortar
from comparisons.formulations.timings import summed
from comparisons.kit.progress import Progress
from scenes.describe import describe
from scenes.read import Scene, load_scene
from scenes.results import ModesResult
from scenes.run import run_modes
from scenes.run_matching import match_unstable
from scenes.spec.analysis import ComplexEigenvalueAnalysis
from scenes.spec.body import Backend, BodySpec
from scenes.spec.mesh import MeshSpec
from scenes.variants import with_contact

FREQUENCY_BOUND = 0.01
"""Largest relative difference of frequencies that agree."""
GROWTH_BOUND = 0.15
"""Largest relative difference of growth rates that agree."""


@dataclass(frozen=True)
class PairingsStudy:
    """What is run.

    Parameters
    ----------
    pairings
        Backends of pad and disc; the others are compared with the first.
    refined_degree
        Degree, in every direction, that the last pairing is run with once more.
    overrides
        Changes of the ``disc_pad`` scene.
    """

    pairings: tuple[tuple[Backend, Backend], ...] = (
        ("fe", "fe"),
        ("fe", "iga"),
        ("iga", "fe"),
        ("iga", "iga"),
    )
    refined_degree: int = 3
    overrides: tuple[str, ...] = ()

    def scene(self, backends: tuple[Backend, Backend]) -> Scene:
        """The scene in one pairing of pad and disc, with mortar contact."""
        scene = load_scene(Path("disc_pad"), self.overrides)
        bodies = {
            name: replace(scene.bodies[name], backend=backend)
            for name, backend in zip(("pad", "disc"), backends, strict=True)
        }
        return with_contact(replace(scene, bodies=bodies), formulation=Mortar())

    def refined(self, backends: tuple[Backend, Backend]) -> Scene:
        """The same with bodies of :attr:`refined_degree`."""
        scene = self.scene(backends)
        bodies = {name: _of_degree(b, self.refined_degree) for name, b in scene.bodies.items()}
        return replace(scene, bodies=bodies)


DEFAULT = PairingsStudy()


def run_pairings(progress: Progress, study: PairingsStudy = DEFAULT) -> dict[str, Any]:
    """Unstable modes of every pairing, and how far they are from those of the first.

    Returns
    -------
    dict
        Plain data: ``study``; ``bounds`` of ``frequency`` and ``growth``, the relative differences
        within which modes agree; ``max_frequency`` (Hz) and ``growth_threshold`` (1/s); ``runs``
        with ``pad`` and ``disc`` (backends), ``dofs``, ``seconds``, ``timings``, ``window`` and
        ``unstable`` modes (``frequency``, ``growth``, ``residual``, ``condition``);
        ``differences``, for each run but the first what
        :func:`scenes.run_matching.match_unstable` says of the first and it; ``refined``, the run of
        higher degree with ``difference``, the same of the last run and it; ``timings`` over all.
    """
    analysis = study.scene(study.pairings[0]).analysis
    assert isinstance(analysis, ComplexEigenvalueAnalysis)
    runs: list[dict[str, Any]] = []
    differences = []
    first: ModesResult | None = None
    for backends in study.pairings:
        progress.step(f"disc and pad, {' on '.join(backends)}")
        result = run_modes(study.scene(backends), listener=progress.stage)
        runs.append(_described(result, backends))
        if first is None:
            first = result
            continue
        differences.append(match_unstable(first, result))
    last = study.pairings[-1]
    progress.step(f"disc and pad, {' on '.join(last)}, degree {study.refined_degree}")
    refined = run_modes(study.refined(last), listener=progress.stage)
    described = _described(refined, last) | {"difference": match_unstable(result, refined)}
    return {
        "study": asdict(study),
        "bounds": {"frequency": FREQUENCY_BOUND, "growth": GROWTH_BOUND},
        "max_frequency": analysis.max_frequency,
        "growth_threshold": analysis.growth_threshold,
        "runs": runs,
        "differences": differences,
        "refined": described,
        "timings": summed(run["timings"] for run in (*runs, described)),
    }


def _of_degree(body: BodySpec, degree: int) -> BodySpec:
    fe, iga = body.mesh.fe, body.mesh.iga
    return replace(
        body,
        mesh=MeshSpec(
            fe=fe and replace(fe, degree=degree),
            iga=iga and replace(iga, degree=(degree,) * len(iga.degree)),
        ),
    )


def _described(result: ModesResult, backends: tuple[Backend, Backend]) -> dict[str, Any]:
    """What of a run is kept."""
    described = describe(result)
    eigenvalues = {value["mode"]: value for value in described["eigenvalues"]}
    return {
        "pad": backends[0],
        "disc": backends[1],
        "dofs": described["dofs"]["free"],
        "seconds": described["seconds"],
        "timings": described["timings"],
        "window": described["window"],
        "unstable": [
            {
                "frequency": mode["frequency"],
                "growth": mode["growth"],
                **{k: eigenvalues[mode["mode"]][k] for k in ("residual", "condition")},
            }
            for mode in described["unstable"]
        ],
    }
