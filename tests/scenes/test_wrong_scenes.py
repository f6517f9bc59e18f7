"""Some hundred inputs that are wrong as people get them wrong: each is refused by its field."""

import pytest
from bad_inputs import complaint_of_row, rows

from scenes.spec.problems import SceneError
from scenes.spec.reading import load_scene

GROUPS = sorted({base for base, *_ in rows("read")})


def met_badly(part, of_base):
    found = [complaint_of_row(part, *row) for row in rows(part) if row[0] == of_base]
    return [told for told in found if told]


@pytest.mark.parametrize("base", GROUPS)
def test_what_reading_refuses(base):
    assert met_badly("read", base) == []


@pytest.mark.parametrize(
    "base",
    [
        pytest.param(base, marks=pytest.mark.slow if base == "disc_pad" else ())
        for base in sorted({base for base, *_ in rows("built")})
    ],
)
def test_what_building_refuses(base):
    assert met_badly("built", base) == []


def fields_of(base, overrides):
    with pytest.raises(SceneError) as caught:
        load_scene(base, overrides)
    return [fault.field for fault in caught.value.faults]


def test_faults_are_told_together_those_of_single_fields_first():
    single = [
        "bodies.pad.material={E=-1.0,nu=0.7,rho=-3.0}",
        "analysis.max_frequency=-3",
        "loads=[{surface='pad.top',pressure='x'},{surface='pad.side',pressure=1.0}]",
    ]
    between = [
        "contacts.pad_disc.b='disc.to'",
        "contacts.pad_disc.a='pad.top'",
        "bodies.disc.mesh.iga.elements=[1,1]",
        "bodies.disc.supports=[{surface='innr'}]",
    ]
    assert fields_of("disc_pad", [*single, *between]) == [
        "bodies.pad.material.E",
        "analysis.max_frequency",
        "loads.0.pressure",
    ]
    assert fields_of("disc_pad", between) == [
        "bodies.disc.mesh.iga.elements",
        "bodies.disc.supports.0.surface",
        "contacts.pad_disc.b",
        "contacts.pad_disc.a",
    ]
