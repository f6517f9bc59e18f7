"""Figures of the paper made by themselves, on scenes that a test may change."""

from comparisons.study.session import Session


def made(figure, mesh, change=lambda scene: scene):
    """Tables and arrays of a figure on a kind of mesh."""
    session = Session(None)
    session.begin({name: change(part) for name, part in figure.inputs(mesh).items()})
    return figure.evaluate(mesh, session), session.arrays
