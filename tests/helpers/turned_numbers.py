"""Wedges by turned test functions: numbers on any ranks."""

from blocks import assemble, two_blocks

from cea.eigen.turned_field import TurnedField


def turned_numbers(backend):
    """Sizes, and what holds at which X, of penalties and of ties."""
    result = {}
    for name, method, P, form in (
        ("penalty", {"method": "gpts", "points": 3}, 1e5, "penalty"),
        ("tied", {"method": "mortar"}, float("inf"), None),
    ):
        data = two_blocks(backend, method, held=True, mu=0.7, P=P)
        if form is not None:
            data["contacts"]["interface"]["form"] = form
        field = TurnedField.of(assemble(data).pencil().at())
        depths = [-50.0, 10.0]
        result[name] = [field.tests.constraints, *(field.holds(X) for X in depths)]
        result[f"{name} norms"] = [field.tests.turn.matrix.norm(), field.tests.turn.normals.norm()]
        field.free()
    return result
