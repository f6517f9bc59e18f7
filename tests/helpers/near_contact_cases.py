"""A block that rubs on a long bar, and what lies near their contact."""

from blocks import assemble, two_blocks

from cea.eigen.driver import solve_modes


def on_a_bar(upper="fe", method=None, *, form=None, mu=0.4, turned=False, lower="fe"):
    """Scene of a small block on one end of a bar twelve times as long, both held."""
    placement = {"axis": [1.0, 2.0, -0.5], "angle": 37.0} if turned else None
    data = two_blocks("fe", method or {"method": "gpts", "points": 3}, placement, mu=mu, held=True)
    for name, backend in (("upper", upper), ("lower", lower)):
        data["bodies"][name]["backend"] = backend
    bar = data["bodies"]["lower"]
    bar["geometry"]["size"] = [6.0, 1.1, 0.4]
    bar["mesh"]["fe"] |= {"degree": 1, "elements": [18, 4, 1]}
    bar["mesh"]["iga"]["elements"] = [12, 3, 1]
    data["bodies"]["upper"]["mesh"]["fe"] |= {"degree": 1, "elements": [2, 3, 1]}
    data["bodies"]["upper"]["mesh"]["iga"]["elements"] = [1, 1, 1]
    if form:
        data["contacts"]["interface"]["form"] = form
    return data


def near_numbers():
    """Size and modes of what lies near, and modes of the whole, on any ranks."""
    pencil = assemble(on_a_bar()).pencil(parted_from=0)
    near = pencil.near_contact
    assert near is not None
    matrices = near.at()
    part, whole = solve_modes(near, 0.6), solve_modes(pencil, 0.4)
    return {
        "size": [matrices.size],
        "near": part.frequencies.tolist(),
        "whole": whole.frequencies.tolist(),
        "complete": [part.window.complete, whole.window.complete],
    }
