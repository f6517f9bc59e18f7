"""Study of the crowned pad: points of comparison, closures, measures, rules, files."""

import numpy as np
import pytest

from cea.contact.formulations import GaussPointToSurface, Grid
from comparisons.kit.progress import Progress
from comparisons.paper.claims import equilibrium_rules
from comparisons.paper.common.families import BACKEND_OF
from comparisons.paper.common.store import STORED, fingerprint
from comparisons.paper.crowned_pad import measures
from comparisons.paper.crowned_pad.case import (
    COLLOCATION,
    CONTACT,
    EXACT,
    FINER,
    PAD,
    PRESSURES,
    QUADRATURE,
    WEIGHTED,
    CrownedCase,
    formulations,
)
from comparisons.paper.crowned_pad.drawing import draw_study
from comparisons.paper.crowned_pad.study import CROWNED_PAD
from scenes import run_modes
from scenes.results.record import read_record

QUIET = Progress(step=lambda name: None, stage=lambda stage: None)
COARSE = {
    f"bodies.{body}.mesh.{backend}.elements": elements
    for body, both in {"pad": ([2, 6, 1], [3, 7, 1]), "disc": ([4, 12, 1], [5, 16, 1])}.items()
    for backend, elements in zip(("fe", "iga"), both, strict=True)
} | {"analysis.max_frequency": 1500.0}


@pytest.fixture(scope="module", params=["NURBS", "hexahedra"])
def run(request):
    """A coarse run of each backend, with 4 x 4 Gauss points."""
    case = CrownedCase(GaussPointToSurface(4), 1e6)
    backend = BACKEND_OF[request.param]
    coarse = {path: v for path, v in COARSE.items() if "mesh" not in path or backend in path}
    return run_modes(case.scene(request.param).change(coarse))


def test_common_points_lie_on_the_crowned_face():
    pad = CrownedCase(Grid(4), 1e6).scene("NURBS").bodies[PAD].geometry
    r, theta, x = measures.common_points(pad)
    x = x.reshape(len(r), len(theta), 3)
    np.testing.assert_allclose(np.hypot(x[..., 0], x[..., 1]), r[:, None] + 0 * theta, rtol=1e-14)
    chord = 2 * r[:, None] * np.sin(np.deg2rad(theta - 45.0) / 2)
    np.testing.assert_allclose(x[..., 2] - 0.012, chord**2 / (2 * 20.0), atol=1e-16)


def test_closures_are_those_that_the_contact_meets(run):
    """At the points of the contact itself, which the law met."""
    points = run.interfaces[CONTACT].points
    state = run.steady.contacts[CONTACT]
    found = measures.closures(run, points.x)
    np.testing.assert_allclose(found, state.closure, rtol=0, atol=1e-8 * np.abs(found).max())


def test_pressures_kept_add_up_to_the_force(run):
    """Their mean is that of the load on the pad's back, as nearly as few midpoints sum it."""
    kept = measures.kept(run)
    pressure = np.reshape(kept["pressure"], (measures.RADII, measures.ANGLES))
    r, _, _ = measures.common_points(run.scene.bodies[PAD].geometry)
    mean = (pressure.mean(axis=1) * r).sum() / r.sum()
    assert mean == pytest.approx(1e6, rel=0.02)
    assert kept["force"] == pytest.approx(1e6 * run.bodies[PAD].surfaces["top"].area, rel=1e-3)
    assert 0.5 < kept["closed"] < 0.9
    law = run.scene.contacts[CONTACT].law
    np.testing.assert_allclose(
        np.array(kept["stiffness"]) ** 2, law.m**2 * law.c * np.array(kept["pressure"]), rtol=1e-10
    )


@pytest.mark.parametrize("family", ["NURBS", "hexahedra", "tetrahedra"])
def test_cases_differ_in_what_they_say_alone(family):
    exact = CrownedCase(formulations(family)[EXACT], 3e5)
    scene, finer = (
        exact.scene(family),
        CrownedCase(exact.formulation, 3e5, finer=True).scene(family),
    )
    assert scene.loads[0].pressure == 3e5
    assert scene.contacts == finer.contacts
    counts = [
        (mesh.fe or mesh.iga).elements
        for mesh in (each.bodies[PAD].mesh for each in (scene, finer))
    ]
    assert np.prod(counts[1]) > 3 * np.prod(counts[0])
    cells = {b.mesh.fe.cell for b in scene.bodies.values() if b.mesh.fe is not None}
    assert cells == {"NURBS": set(), "hexahedra": {"hexahedron"}}.get(family, {"tetrahedron"})


def evidence(**families):
    return {CROWNED_PAD.name: {"families": families}}


def case(pressure, P=1.0, growth=0.0):
    return {"pressure": pressure, "P": P, "growth": growth}


def test_rules_of_equilibrium():
    exact = [case([1.0, 2.0, 2.0]), case([3.0, 4.0, 0.0], P=2.0, growth=50.0)]
    close = [case([1.03, 2.0, 2.0]), case([3.0, 4.0, 0.1], P=2.01, growth=48.0)]
    far = [case([1.3, 2.0, 2.0]), case([3.0, 4.0, 0.2], P=2.2, growth=54.0)]
    found = {EXACT: exact, QUADRATURE: close, COLLOCATION: far, WEIGHTED: far, FINER: close}
    ours = evidence(NURBS=found, hexahedra=found | {QUADRATURE: far, COLLOCATION: close})
    assert equilibrium_rules.equilibrium(ours, "NURBS").verdict == "holds"
    assert equilibrium_rules.equilibrium(ours, "NURBS").value == pytest.approx(2.0)
    assert equilibrium_rules.equilibrium(ours, "hexahedra").verdict == "does not"
    assert equilibrium_rules.stiffness(ours, "NURBS").verdict == "depends"
    assert equilibrium_rules.stiffness(ours, "NURBS").value == pytest.approx(0.1)
    assert equilibrium_rules.growth(ours, "NURBS").value == pytest.approx(2.0)
    assert equilibrium_rules.growth(ours, "NURBS").verdict == "holds"
    assert equilibrium_rules.growth(ours, "hexahedra").verdict == "does not"


@pytest.mark.grid(quick=1)
@pytest.mark.parametrize("backend", ["fe", "iga"])
def test_stored_data_are_those_of_the_scenes_as_they_are(backend, tmp_path):
    """Found by their fingerprint; of every case at every load; drawn and tabled."""
    data = read_record(STORED / f"figure_{CROWNED_PAD.name}_{backend}.json.gz")
    assert data["fingerprint"] == fingerprint(CROWNED_PAD.inputs(backend))
    for cases in data["families"].values():
        for row in cases.values():
            assert len(row) == len(PRESSURES)
            closed = [each["closed"] for each in row]
            assert closed == sorted(closed)
    assert draw_study(data, tmp_path / "study.png", "title").stat().st_size > 10_000
    rows, line = CROWNED_PAD.tables(data, "stem")
    assert len(rows.rows) == sum(len(cases) * len(PRESSURES) for cases in data["families"].values())
    assert len(line.rows) == len(rows.rows) * measures.ANGLES
