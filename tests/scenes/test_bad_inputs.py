"""Bad input is refused: by name, in bounded time and memory, and by nothing but a refusal."""

import numpy as np
import pytest
from bad_inputs import (
    HOSTILE,
    NAMES,
    Bad,
    coarse,
    complaint,
    faults_of,
    mutations,
    patience,
    random_mutation,
    valid,
)
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cea.errors import InputError
from cea.expressions import Formula
from scenes import open_result, run_scene, save_result
from scenes.spec.problems import SceneError
from scenes.spec.reading import read_scene

SEED = 12
RUNS = 200
"""Mutations that are run."""
quickly = settings(
    max_examples=60,
    deadline=None,  # hangs are told by `patience`; a loaded machine is slow
    derandomize=True,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
)
numbers = st.floats() | st.integers() | st.integers(10**300, 10**310)
plain = st.recursive(
    st.none() | st.booleans() | numbers | st.text(max_size=20),
    lambda part: (
        st.lists(part, max_size=4) | st.dictionaries(st.text(max_size=8), part, max_size=4)
    ),
    max_leaves=20,
)


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_every_mutation_of_a_scene(name, backend):
    told = [complaint(bad, read_scene) for bad in mutations(valid(name, backend))]
    assert [one for one in told if one] == []
    assert len(told) > 500


@pytest.mark.slow
def test_what_is_read_runs_or_is_refused(tmp_path):
    """Mutations that reading takes, as it may, run to a result that opens again, or are refused."""

    def run(scene):
        open_result(save_result(run_scene(scene), tmp_path / "r.json"))

    rng, told, count = np.random.default_rng(SEED), [], 0
    while count < RUNS:
        bad = random_mutation(rng, coarse)
        scene = refused_or_read(read_scene, bad.value)
        if scene not in (None, NAMELESS):
            count += 1
            told.append(complaint(Bad(bad.words, scene, None), run))
    assert [one for one in told if one] == []


NAMELESS = "refused without a name"


def refused_or_read(read, value):
    """What is read, or None where it is refused by name."""
    with patience():
        try:
            return read(value)
        except (InputError, SceneError) as error:
            named = all(fault.field and fault.allowed for fault in faults_of(error))
            return None if named else NAMELESS


@quickly
@given(st.sampled_from(NAMES), st.data())
def test_random_values_in_random_places(name, data):
    scene = valid(name)
    table = scene
    while True:
        key = data.draw(
            st.sampled_from(sorted(table) if isinstance(table, dict) else range(len(table)))
        )
        if not isinstance(table[key], dict | list) or not table[key] or data.draw(st.booleans()):
            break
        table = table[key]
    table[key] = data.draw(plain)
    assert refused_or_read(read_scene, scene) != NAMELESS


@quickly
@given(st.text(alphabet="xy0123456789.+-*/()<>=&|^, sincoexplgqrtb", max_size=50))
def test_random_formulas_give_a_finite_number_or_a_refusal(text):
    names = {"x": "parameters.x", "y": "parameters.y"}

    def values(text):
        formula, at = Formula(text, names), {"parameters.x": 0.3, "parameters.y": -2.0}
        return [formula.at(at), formula.derivative("parameters.x", at)]

    found = refused_or_read(values, text)
    assert found is None or np.isfinite(found).all()


@pytest.mark.parametrize("text", HOSTILE, ids=lambda text: text[:20])
def test_hostile_formulas_are_refused(text):
    def read(text):
        return Formula(text, {"x": "parameters.x", "y": "parameters.y"}).at(
            {"parameters.x": 0.3, "parameters.y": -2.0}
        )

    assert refused_or_read(read, text) is None
