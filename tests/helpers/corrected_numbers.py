"""Wedges by corrected test functions: numbers on any ranks."""

from blocks import assemble, two_blocks

from cea.eigen.corrected_tests import CorrectedTests


def corrected_numbers(backend):
    """Sizes, and what holds at which X, of penalties and of ties."""
    result = {}
    for name, method, P, form in (
        ("penalty", {"method": "gpts", "points": 3}, 1e5, "penalty"),
        ("tied", {"method": "mortar"}, float("inf"), None),
    ):
        data = two_blocks(backend, method, held=True, mu=0.7, P=P)
        if form is not None:
            data["contacts"]["interface"]["form"] = form
        tests = CorrectedTests.of(assemble(data).pencil().at())
        result[name] = [tests.inner.getSize()[0], *(tests.holds(X) for X in (-50.0, 10.0))]
        result[f"{name} norm"] = tests.normals.norm()
        tests.free()
    return result
