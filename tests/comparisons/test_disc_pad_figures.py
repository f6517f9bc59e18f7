"""Figures of complex eigenvalue analysis: measures, false stiffness of lumping, claims, files."""

import csv
from dataclasses import replace
from math import tau
from types import SimpleNamespace

import numpy as np
import pytest
from dolfinx.mesh import exterior_facet_indices

from cea.contact.formulations import GaussPointToSurface, Greville, Grid, NodeToSurface
from cea.timing import StageTimer
from comparisons.kit.progress import Progress
from comparisons.paper.both_backends import make_both
from comparisons.paper.claims import rules as claim_rules
from comparisons.paper.claims.catalogue import CLAIMS
from comparisons.paper.claims.claim import Claim, Judgement
from comparisons.paper.claims.judge import judged, write_claims
from comparisons.paper.common.store import STORED, make_figure
from comparisons.paper.disc_pad import measures as cea_measures
from comparisons.paper.disc_pad.case import CONTACT, CeaCase, Resolution
from comparisons.paper.disc_pad.figures import FIGURE_14, GPTS, LUMPED
from comparisons.paper.disc_pad.lumping import false_shifts, rotation_ratio
from comparisons.paper.disc_pad.mode_shapes import SHAPES
from comparisons.paper.disc_pad.runs import Runs, compare_spectra
from comparisons.paper.disc_pad.stability_diagram import Measure, Panel, StabilityFigure
from comparisons.paper.normal_compliance import NORMAL_COMPLIANCE
from comparisons.paper.registry import FIGURES
from scenes.building.build import build_bodies, build_interfaces, build_system
from scenes.results.record import read_record
from scenes.spec.plain import as_data

QUIET = Progress(step=lambda name: None, stage=lambda stage: None)


ELEMENTS = {"pad": ([3, 4, 1], [3, 5, 1]), "disc": ([6, 16, 1], [5, 20, 1])}
COARSE = Resolution(
    max_frequency=5e3,
    disc_size=0.03,
    pad_size=0.02,
    overrides=tuple(
        f"bodies.{body}.mesh.{backend}.elements={each}"
        for body, both in ELEMENTS.items()
        for backend, each in zip(("fe", "iga"), both, strict=True)
    ),
)
"""Disc and pad on meshes that run in a second, up to 5 kHz."""
PLAIN, FALSE = (replace(case, resolution=COARSE) for case in (GPTS, LUMPED))
"""GPTS on these meshes without and with lumping."""


def coarse_case(**choices):
    """GPTS of 5 x 5 points on these meshes."""
    return CeaCase(GaussPointToSurface(5), 1e9, resolution=COARSE, **choices)


def assembled(case, family):
    """The case without its modes."""
    scene, timer = case.scene(family), StageTimer()
    bodies = build_bodies(scene, timer)
    system = build_system(scene, bodies, build_interfaces(scene, bodies, timer), timer)
    return SimpleNamespace(system=system)


def matched(*pairs, groups=(), alone=(0, 0)):
    """A match of unstable modes, each (growth, Hz, reference growth, reference Hz)."""

    def group(growth, hertz, other, reference):
        return {"lambda": [[growth, tau * hertz], [other, tau * reference]]}

    return {
        "unstable": [group(*pair) for pair in pairs],
        "groups": [group(*pair) for pair in groups],
        "only_first": alone[0],
        "only_second": alone[1],
        "unpaired": list(alone),
    }


def test_coinciding_modes_are_counted_with_those_alone():
    match = matched(
        (100, 5000, 100.5, 5040), (50, 9000, 80, 9010), (9, 1000, 9, 1020), alone=(1, 0)
    )
    assert cea_measures.coinciding(match) == pytest.approx(2 / 4)
    assert cea_measures.coinciding(match, growth=True) == pytest.approx(1 / 4)
    assert cea_measures.coinciding(matched()) == 1.0
    assert cea_measures.largest_growth_difference(match) == pytest.approx(30)


def test_growth_of_a_mode_that_the_other_run_does_not_have_is_lost():
    match = matched((100, 5000, 110, 5000))
    match["unstable"][0]["modes"] = [[1], [0]]
    reference = {"unstable": [{"growth": 110.0}]}
    case = {"unstable": [{"growth": 30.0}, {"growth": 100.0}]}
    assert cea_measures.growth_difference(reference, case, match) == pytest.approx(30)
    case["unstable"].pop(0)
    match["unstable"][0]["modes"] = [[0], [0]]
    assert cea_measures.growth_difference(reference, case, match) == pytest.approx(10)


def test_sums_and_shifts_keep_to_their_band():
    case = {"unstable": [{"frequency": f, "growth": g} for f, g in ((2e3, 5.0), (12e3, 7.0))]}
    assert cea_measures.growth_sum(case) == 12.0
    assert cea_measures.growth_sum(case, (0.0, 10e3)) == 5.0
    match = matched(groups=((0, 1010, 0, 1000), (0, 14100, 0, 14000), (30, 2000, 0, 2000)))
    assert cea_measures.largest_shift(match) == pytest.approx(0.01)
    assert cea_measures.largest_shift(match, (13e3, 20e3)) == pytest.approx(1 / 140)
    assert cea_measures.largest_distance(match) == pytest.approx(0.01)


def test_the_linearised_law_is_the_tangent(tmp_path):
    data = NORMAL_COMPLIANCE.compute("iga", QUIET)
    closure, pressure, linear = (np.array(data[k]) for k in ("closure", "pressure", "linearised"))
    at = np.argmin(np.abs(closure - NORMAL_COMPLIANCE.closure))
    assert linear[at] == pytest.approx(pressure[at])
    slopes = [np.diff(curve[at - 1 : at + 2 : 2])[0] for curve in (linear, pressure)]
    assert slopes[0] == pytest.approx(slopes[1])  # a parabola's chord is its tangent
    assert not pressure[closure <= 0].any()


def test_error_of_the_linearised_law_in_closed_form():
    """With m = 2 the change is 2 e + e^2 of which 2 e is linear."""
    for part in (0.01, 0.1, 1.0):
        assert NORMAL_COMPLIANCE.error(part) == pytest.approx(part / (2 + part))


def test_normal_compliance_has_no_backend(tmp_path):
    made = make_both(NORMAL_COMPLIANCE, tmp_path, QUIET)
    assert list(made.made) == ["iga"]
    assert made.pictures == []
    rows = list(csv.DictReader((tmp_path / "figure_1_iga_curves.csv").open()))
    law = NORMAL_COMPLIANCE.law
    for row in rows[::10]:
        x = np.array(float(row["closure"]))
        assert float(row["pressure"]) == pytest.approx(float(law.pressure(x)))


def test_cases_on_other_meshes():
    assert CeaCase(Greville(), 1e9).on("hexahedra").formulation == NodeToSurface()
    assert CeaCase(Grid(10), 1e9).on("tetrahedra").formulation == Grid(4)
    assert CeaCase(Grid(10), 1e9).on("NURBS").formulation == Grid(10)
    mesh = CeaCase(GaussPointToSurface(5), 1e9, boundary="refined").scene("NURBS").bodies["disc"]
    through = mesh.mesh.iga.through
    assert {0.09, 0.14} < set(through["r"])
    assert len(through["r"]) == len(through["theta"]) == 6
    ignored = CeaCase(GaussPointToSurface(5), 1e9, boundary="ignored").scene("hexahedra")
    assert ignored.bodies["disc"].mesh.fe.through == {}
    assert GPTS.scene("NURBS").contacts[CONTACT].mu == 0.7


def test_higher_degrees_take_larger_elements():
    def elements(degree, family):
        mesh = CeaCase(GaussPointToSurface(5), 1e9, degree=degree).scene(family).bodies["disc"].mesh
        return mesh.iga.elements if family == "NURBS" else mesh.fe.elements

    assert [elements(p, "NURBS") for p in (2, 3, 4, 5)] == [
        *2 * [(16, 80, 2)],
        (12, 60, 2),
        (10, 48, 1),
    ]
    assert [elements(p, "hexahedra")[:2] for p in (2, 3, 4)] == [(9, 60), (6, 40), (4, 30)]


def test_degrees_that_lagrange_elements_do_not_have_are_no_cases():
    cases = FIGURE_14.panels[0].on("hexahedra").values()
    assert [case.degree for case in cases] == [2, 2, 3, 4]
    assert [case.degree for case in FIGURE_14.panels[0].on("NURBS").values()] == [2, 2, 3, 4, 5]
    data = read_record(STORED / "figure_14_fe.json.gz")
    assert FIGURE_14.measure(data, "hexahedra", Measure("", 0, 4, cea_measures.shift())) is None
    assert FIGURE_14.measure(data, "hexahedra", Measure("", 0, 3, cea_measures.shift())) > 0


def test_divided_hexahedra_fill_the_same_bodies():
    case = coarse_case(divided=True)
    hexahedra = build_bodies(case.scene("hexahedra"), StageTimer())
    for name, body in build_bodies(case.scene("tetrahedra"), StageTimer()).items():
        whole = hexahedra[name]
        assert body.space.scalar.mesh.topology.cell_name() == "tetrahedron"
        assert body.num_scalar_dofs == whole.num_scalar_dofs
        for surface, side in body.surfaces.items():
            assert side.num_elements == 2 * whole.surfaces[surface].num_elements
            assert side.area == pytest.approx(whole.surfaces[surface].area, rel=1e-12)
        # A face divided one way on one side and another way on the other would be outside twice.
        body.space.scalar.mesh.topology.create_connectivity(2, 3)
        outside = exterior_facet_indices(body.space.scalar.mesh.topology)
        assert len(outside) == sum(side.num_elements for side in body.surfaces.values())


def test_divided_hexahedra_are_told_in_the_inputs_of_figures():
    """As stored figures tell them; the scene itself says what is meshed."""
    case = CeaCase(GaussPointToSurface(5), 1e9, divided=True)
    inputs, scene = case.inputs("tetrahedra"), case.scene("tetrahedra")
    assert "divided into six" in inputs["description"]
    for name, body in scene.bodies.items():
        assert body.mesh.fe.cell == "tetrahedron"
        described = inputs["bodies"][name]["mesh"]["fe"]
        assert described == as_data(body)["mesh"]["fe"] | {"cell": "hexahedron"}
    whole = replace(case, divided=False)
    assert whole.inputs("hexahedra") == case.inputs("hexahedra")
    assert whole.inputs("hexahedra") == as_data(whole.scene("hexahedra"))


def test_tetrahedra_trace_the_pad_where_hexahedra_are_divided():
    case = coarse_case(divided=True)
    assert case.on("hexahedra") == coarse_case().on("hexahedra")
    assert case.on("tetrahedra").boundary == "traced"
    assert coarse_case().on("tetrahedra").boundary == "ignored"
    runs = Runs()
    tetrahedra = runs.spectrum(case, "tetrahedra")
    hexahedra = runs.spectrum(case, "hexahedra")
    assert tetrahedra.data["dofs"] == hexahedra.data["dofs"]
    assert tetrahedra.label == f"divided hexahedra, {hexahedra.label}"
    # Fewer functions of the same nodes: quadratic tetrahedra are the stiffer ones.
    shifts = [
        g["lambda"][0][1] / g["lambda"][1][1] - 1
        for g in compare_spectra(tetrahedra, hexahedra)["groups"]
    ]
    assert len(shifts) > 4
    assert 0 < np.median(shifts) < 0.1


def test_pad_has_as_many_greville_points_as_the_paper_says():
    scene = CeaCase(Greville(), 1e9).scene("NURBS")
    scene = replace(scene, contacts={})
    pad = replace(scene, bodies={"pad": scene.bodies["pad"]})
    surface = build_bodies(pad, StageTimer())["pad"].surfaces["bottom"]
    assert len(surface.abscissae("greville")) == 104


@pytest.mark.parametrize("family", ["NURBS", "hexahedra", "tetrahedra"])
def test_rotation_of_both_bodies_is_free_without_lumping(family):
    assert abs(rotation_ratio(assembled(PLAIN, family))) < 1e-12


def test_lumping_gives_a_rotation_false_stiffness_on_nurbs_only():
    """On traced quadratic hexahedra lumping is Simpson's rule, exact for squares of rotations."""
    nurbs, hexahedra = (rotation_ratio(assembled(FALSE, f)) for f in ("NURBS", "hexahedra"))
    assert nurbs > 0.05
    assert abs(hexahedra) < 1e-3


def test_false_stiffness_shifts_modes_as_lumping_does_at_low_stiffness():
    runs = Runs()
    plain, lumped = (replace(case, P=1e6) for case in (PLAIN, FALSE))
    expected = false_shifts(runs.result(plain, "NURBS"), runs.result(lumped, "NURBS"))
    spectra = [runs.spectrum(case, "NURBS") for case in (lumped, plain)]
    groups = compare_spectra(*spectra)["groups"]
    assert len(groups) > 4
    found = [g["lambda"][0][1] / g["lambda"][1][1] - 1 for g in groups]
    false = [expected[g["modes"][1]].mean() for g in groups]
    assert max(false) > 1e-5
    assert found == pytest.approx(false, rel=0.05, abs=0.02 * max(false))


def test_spectrum_agrees_with_itself_and_its_parts_are_sound():
    runs = Runs()
    spectrum = runs.spectrum(PLAIN, "NURBS")
    assert runs.spectrum(replace(PLAIN), "NURBS") is spectrum
    match = compare_spectra(spectrum, spectrum)
    assert cea_measures.largest_distance(match) == 0
    assert cea_measures.unpaired(match) == 0
    assert cea_measures.motion_ratio(spectrum.data, spectrum.data, match, "contact_gap") == 1
    assert all(group["assurance"] == pytest.approx(1) for group in match["groups"])


def small_figure():
    """Two formulations in one diagram."""
    return StabilityFigure(
        "small",
        "small",
        (Panel("P = 10⁹", (PLAIN, FALSE)),),
        (
            Measure("shift", 0, 1, cea_measures.shift()),
            Measure("nothing", 0, 0, cea_measures.shift()),
        ),
    )


@pytest.mark.slow
def test_diagrams_of_both_backends_are_stored_and_overlaid(tmp_path):
    figure = small_figure()
    made = make_both(figure, tmp_path, QUIET)
    assert [path.name for path in made.pictures] == ["figure_small_both.png"]
    assert made.pictures[0].stat().st_size > 20_000
    rows = made.made["fe"].numbers.rows
    assert [row[0] for row in rows] == ["hexahedra: shift", "tetrahedra: shift"]
    modes = list(csv.DictReader((tmp_path / "figure_small_fe_modes.csv").open()))
    assert {row["mesh"] for row in modes} == {"hexahedra", "tetrahedra"}
    matches = list(csv.DictReader((tmp_path / "figure_small_iga_matches.csv").open()))
    ratios = [float(row["frequency"]) / float(row["reference_frequency"]) for row in matches]
    assert made.made["iga"].numbers.rows[0][2] == pytest.approx(max(abs(r - 1) for r in ratios))
    runs: list[str] = []
    again = make_both(figure, tmp_path, Progress(step=runs.append, stage=lambda stage: None))
    assert all(each.reused for each in again.made.values())
    assert runs == []


SOFT = {"plain": replace(PLAIN, P=1e6), "lumped": replace(FALSE, P=1e6)}


@pytest.mark.slow
def test_shapes_and_lines_of_a_mode(tmp_path):
    shapes, line = (replace(figure, **SOFT) for figure in SHAPES)
    made = make_figure(shapes, "iga", tmp_path, QUIET)
    assert made.pictures[0].stat().st_size > 20_000
    made = make_figure(line, "iga", tmp_path, QUIET)
    assert "bodies" not in read_record(made.data_file)["families"]["NURBS"]["plain"]
    found = read_record(tmp_path / "figure_4_iga.json.gz")["families"]["NURBS"]["plain"]
    arc, disc, pad = (np.array(found["line"][n], dtype=float) for n in ("arc", "disc", "pad"))
    assert np.abs(disc).max() == pytest.approx(1)
    # The line is a chord: the pad's radial ends cut it at 0.115 tan 20 degrees.
    touched = np.abs(arc) < 0.115 * np.tan(np.radians(20)) + 1e-9
    assert (np.isfinite(pad) == touched).all()
    for body in found["bodies"].values():
        assert len(body["points"]) == len(body["displacement"])
        assert np.array(body["cells"]).max() == len(body["points"]) - 1
    table = np.genfromtxt(tmp_path / "figure_4_iga_shapes.csv.gz", delimiter=",", skip_header=1)
    points = [body["points"] for body in found["bodies"].values()]
    assert table[len(table) // 2 :, 3:6].tolist() == np.concatenate(points).tolist()


def lumped_evidence(growth, hertz):
    """Figure 6 with one unstable mode, 100 1/s at 5 kHz without lumping."""
    unstable = [{"mode": 0, "frequency": 5e3, "growth": 100.0}]
    labels = [case.on("NURBS").label for case in (GPTS, LUMPED)]
    panel = {
        "title": "",
        "reference": labels[0],
        "cases": {label: {"unstable": unstable} for label in labels},
        "matches": {labels[1]: matched((growth, hertz, 100.0, 5e3))},
    }
    return {"6": {"families": {"NURBS": [panel]}}}


@pytest.mark.parametrize(
    ("growth", "hertz", "verdict"),
    [(100.0, 5e3, "does not"), (120.0, 5e3, "depends"), (100.0, 5.1e3, "holds")],
)
def test_verdict_on_lumped_spectra_follows_the_data(growth, hertz, verdict):
    evidence = lumped_evidence(growth, hertz)
    assert claim_rules.lumped_spectra(evidence, "NURBS").verdict == verdict


def test_claims_are_written_with_every_mesh(tmp_path):
    claim = Claim("name", "It is so", "3", "a number", ("7",), lambda e, f: Judgement("holds", 2.0))
    endless = replace(claim, decide=lambda e, f: Judgement("does not", np.inf))
    every = [judged(each, {"iga": {}, "fe": {}}) for each in (claim, endless)]
    assert "NURBS: holds, 2" in every[0].told()
    table, file = write_claims(every, tmp_path, seconds=1.5)
    rows = list(csv.DictReader(table.open()))
    assert [row["tetrahedra_verdict"] for row in rows] == ["holds", "does not"]
    stored = read_record(file)
    assert (stored["command"], stored["inputs"]) == ("claims", {"figures": ["7"]})
    assert stored["claims"][1]["hexahedra_value"] is None


def test_every_claim_has_the_number_of_the_stored_data_on_every_mesh():
    names = {name for claim in CLAIMS for name in claim.figures}
    evidence = {
        backend: {name: read_record(STORED / f"figure_{name}_{backend}.json.gz") for name in names}
        for backend in ("iga", "fe")
    }
    rows = {row["name"]: row for row in csv.DictReader((STORED / "claims.csv").open())}
    assert list(rows) == [claim.name for claim in CLAIMS]
    for claim in CLAIMS:
        for family, judgement in judged(claim, evidence).judgements.items():
            assert np.isfinite(judgement.value)
            stored = float(rows[claim.name][f"{family}_value"])
            assert stored == pytest.approx(judgement.value, rel=1e-12, abs=0)
            assert rows[claim.name][f"{family}_verdict"] == judgement.verdict


def test_claims_rest_on_figures_that_exist():
    assert len({claim.name for claim in CLAIMS}) == len(CLAIMS)
    assert {name for claim in CLAIMS for name in claim.figures} <= set(FIGURES)
    assert {"1", "4", "5", "6", "13", "14", "15"} <= set(FIGURES)
