"""Some hundred inputs that are wrong as people get them wrong: each is refused by its field."""

import pytest
from wrong_scenes import complaint, faults_of_row, number_of_rows, rows

from scenes.spec.problems import SceneError
from scenes.spec.reading import load_scene

GROUPS = sorted({base for base, *_ in rows("read")})


def met_badly(part, of_base):
    found = []
    for base, changes, field, word in rows(part):
        if base == of_base:
            told = complaint(*faults_of_row(part, base, changes), field, word)
            found += [f"{changes}: {told}"] if told else []
    return found


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


def test_the_table_is_large_and_says_each_once():
    every = [str(row) for part in ("read", "built") for row in rows(part)]
    assert len(every) == len(set(every))
    assert number_of_rows() >= 300


def test_the_table_would_see_what_is_wrong():
    _, changes, field, word = rows("read")[0]
    assert complaint(*faults_of_row("read", "disc_pad", []), field, word) == "accepted"
    found, seconds = faults_of_row("read", "disc_pad", changes)
    assert complaint(found, seconds, field, word) is None
    assert "another field" in complaint(found, seconds, "contacts.pad_disc.b", word)
    assert "not in" in complaint(found, seconds, field, "no such word in it")
    assert "took" in complaint(found, 11.0, field, word)


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
        "bodies.pad.material.nu",
        "bodies.pad.material.rho",
        "analysis.max_frequency",
        "loads.0.pressure",
    ]
    assert fields_of("disc_pad", between) == [
        "bodies.disc.mesh.iga.elements",
        "bodies.disc.supports.0.surface",
        "contacts.pad_disc.b",
        "contacts.pad_disc.a",
    ]


@pytest.mark.parametrize("name", ["geometry", "p", "analysis", "float", "box", "AlongVector"])
def test_a_body_may_have_the_name_of_a_field(name):
    """Paths are told whole, whatever bodies are called."""
    body = (
        "{backend='iga',geometry={shape='box',size=[1,1]},material={E=1,nu=0.3},mesh={},colour=1}"
    )
    assert fields_of("disc_pad", [f"bodies.{name}={body}"]) == [
        f"bodies.{name}.geometry.size",
        f"bodies.{name}.colour",
    ]


@pytest.mark.parametrize("path", ["contacts.pad_disc.a", "bodies.pad.supports[0].surface"])
def test_brackets_and_dots_name_the_same_entry(path):
    dotted = path.replace("[", ".").replace("]", "")
    assert fields_of("disc_pad", [f"{path}='x'"]) == fields_of("disc_pad", [f"{dotted}='x'"])


def test_settings_reach_into_lists():
    overrides = ["loads[0].pressure=2e5", "bodies.disc.mesh.fe.elements[1]=40"]
    scene = load_scene("crowned_pad", overrides)
    assert scene.loads[0].pressure == 2e5
    assert scene.bodies["disc"].mesh.fe.elements == (5, 40, 1)
    other = scene.change("bodies.disc.mesh.fe.elements[0]", 6)
    assert other.bodies["disc"].mesh.fe.elements == (6, 40, 1)


@pytest.mark.parametrize("name", ["the pad", "a.b", "a[0]", "", "a,b"])
def test_names_hold_nothing_that_parts_paths(name):
    disc = load_scene("disc")
    with pytest.raises(SceneError, match="no dot, comma, bracket or blank"):
        disc.change("bodies", {name: disc.bodies["disc"]})
