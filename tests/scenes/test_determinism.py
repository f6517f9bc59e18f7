"""The same run twice: on one rank the same numbers to the last bit."""

import pytest
from covering import covering

from scenes import run_modes
from scenes.spec.reading import load_scene


@pytest.mark.parametrize(
    ("backend", "form"), covering(("fe", "iga"), ("penalty", "saddle"), strength=1)
)
def test_a_run_repeats_itself_to_the_last_bit(backend, form):
    fields = {"contacts.interface.form": form, "contacts.interface.p": 1e3}
    scene = load_scene("blocks", [], backend).change(fields)
    first, second = (run_modes(scene).modes for _ in range(2))
    assert len(first) > 5
    assert first.eigenvalues.tobytes() == second.eigenvalues.tobytes()
    assert first.growth_uncertainties.tobytes() == second.growth_uncertainties.tobytes()
    assert first.conditions.tobytes() == second.conditions.tobytes()
