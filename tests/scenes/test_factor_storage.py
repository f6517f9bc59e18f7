"""Factors go to disk where memory would not do, and the result says so."""

import numpy as np
import pytest

from cea.errors import InputError
from scenes import assemble, run_modes
from scenes.checking import memory
from scenes.checking.memory import estimated_memory
from scenes.running import factor_storage
from scenes.spec.reading import load_scene


def with_memory(monkeypatch, amount: float) -> None:
    for module in (memory, factor_storage):
        monkeypatch.setattr(module, "available_memory", lambda: amount / 0.9)


def test_factors_go_to_disk_where_memory_would_not_do(backend, monkeypatch):
    scene = load_scene("blocks", backend=backend)
    plain = run_modes(scene)
    assert "factors-on-disk" not in [warning.kind for warning in plain.warnings]
    estimate = estimated_memory(scene)
    assert estimate.bytes_with_files < estimate.bytes
    with_memory(monkeypatch, 0.5 * (estimate.bytes + estimate.bytes_with_files))
    result = run_modes(scene)
    (told,) = [warning for warning in result.warnings if warning.kind == "factors-on-disk"]
    assert told.data["memory_with_files"] < told.data["available"] < told.data["memory"]
    np.testing.assert_allclose(
        result.modes.eigenvalues, plain.modes.eigenvalues, rtol=1e-9, atol=1e-9
    )


def test_what_fits_neither_way_is_refused(monkeypatch):
    scene = load_scene("disc_pad", backend="fe")
    estimate = estimated_memory(scene)
    with_memory(monkeypatch, 0.5 * (estimate.bytes + estimate.bytes_with_files))
    monkeypatch.setattr(memory, "free_disk", lambda: 0.5 * estimate.files)
    with pytest.raises(InputError, match=r"GB of factors on disk, where .* GB are free"):
        run_modes(scene)
    with_memory(monkeypatch, 0.9 * estimate.bytes_with_files)
    monkeypatch.setattr(memory, "free_disk", lambda: 100 * estimate.files)
    with pytest.raises(InputError, match="would, the other bodies coarser alike"):
        run_modes(scene)


@pytest.mark.grid(quick=1)
def test_an_assembled_scene_has_its_factors_on_disk_too(backend, monkeypatch):
    """At every value, and frees them before their files go."""
    scene = load_scene("blocks", backend=backend)
    estimate = estimated_memory(scene)
    with_memory(monkeypatch, 0.5 * (estimate.bytes + estimate.bytes_with_files))
    assembled = assemble(scene)
    for mu in (0.2, 0.3, 0.5):
        result = assembled.modes(mu=mu)
        assert "factors-on-disk" in [warning.kind for warning in result.warnings]
        fresh = run_modes(scene.change("contacts.interface.mu", mu))
        np.testing.assert_allclose(result.eigenvalues, fresh.eigenvalues, rtol=1e-9, atol=1e-9)
    assembled.free()
