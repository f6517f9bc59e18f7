"""Supports of a deck: held components, in local frames of nodes where they are cylindrical."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from cea.errors import InputError
from cea.mesh import Floats, Ints
from cea.supports.frames import Cylindrical
from scenes.export.decks.bodies import DeckBody, set_name
from scenes.export.decks.lines import keyword, numbers, set_lines, value_lines
from scenes.spec.body import SupportSpec


@dataclass(frozen=True)
class LocalFrame:
    """A cylindrical frame of some nodes."""

    name: str
    nodes: Ints
    origin: tuple[float, ...]
    axis: tuple[float, ...]

    def directions(self, x: Floats) -> Floats:
        """Radial, circumferential and axial unit vectors at points, (n, 3, 3), a row each."""
        axis = np.asarray(self.axis) / np.linalg.norm(self.axis)
        arm = x - np.asarray(self.origin)
        radial = arm - (arm @ axis)[:, None] * axis
        radial /= np.linalg.norm(radial, axis=1)[:, None]
        axes = np.broadcast_to(axis, radial.shape)
        return np.stack([radial, np.cross(axis, radial), axes], axis=1)


def _is_whole(support: SupportSpec, dim: int) -> bool:
    """Whether every component is held, which no frame changes."""
    held = support.support()
    count = dim if held.components is None else len(set(held.components))
    return count == held.frame.size(dim) == dim


_Frame = tuple[tuple[float, ...], tuple[float, ...]] | None
"""Origin and axis of a cylindrical frame; None, the coordinates of space."""


def local_frames(body: DeckBody) -> list[LocalFrame]:
    """Cylindrical frames that the supports of a body need."""
    frames: dict[tuple[tuple[float, ...], tuple[float, ...]], list[Ints]] = {}
    others: list[tuple[int, _Frame, Ints]] = []
    for i, spec in enumerate(body.spec.supports):
        if _is_whole(spec, body.mesh.dim):
            continue
        frame, nodes = _frame_of(spec), body.nodes_of(spec.surface)
        if frame is not None:
            frames.setdefault(frame, []).append(nodes)
        for number, other, held in others:
            if frame == other or _share_components(spec, frame, body.spec.supports[number], other):
                continue
            if len(np.intersect1d(held, nodes)):
                allowed = f"components of the frame of supports.{number}, whose nodes are shared"
                field = f"bodies.{body.name}.supports.{i}.components"
                raise InputError(field, list(spec.components), allowed)
        others.append((i, frame, nodes))
    return [
        LocalFrame(f"{body.name}-frame-{i}", np.unique(np.concatenate(nodes)), *key)
        for i, (key, nodes) in enumerate(frames.items(), start=1)
    ]


def _frame_of(spec: SupportSpec) -> _Frame:
    frame = spec.support().frame
    if not isinstance(frame, Cylindrical):
        return None
    origin = tuple((*frame.origin, 0.0, 0.0, 0.0)[:3])
    return origin, tuple(frame.axis or (0.0, 0.0, 1.0))


def _share_components(spec: SupportSpec, frame: _Frame, other: SupportSpec, second: _Frame) -> bool:
    """Whether z alone, in space, meets a frame about z: component 3 of both."""
    if frame is not None and second is not None:
        return False
    plain, axis = (spec, second) if frame is None else (other, frame)
    return plain.components == ("z",) and axis is not None and not any(axis[1][:2])


def transform_lines(body: DeckBody) -> Iterator[str]:
    """Local frames of the nodes of a body; part of the model."""
    for frame in local_frames(body):
        yield keyword("NSET", NSET=frame.name)
        yield from set_lines(frame.nodes + body.first_node)
        yield keyword("TRANSFORM", NSET=frame.name, TYPE="C")
        end = np.asarray(frame.origin) + np.asarray(frame.axis)
        yield numbers([*frame.origin, *end])


def boundary_lines(bodies: Mapping[str, DeckBody], **parameters: object) -> Iterator[str]:
    """Held components of all bodies; nothing where there are none."""
    lines = [line for body in bodies.values() for line in _held_lines(body)]
    if lines or parameters:
        yield keyword("BOUNDARY", **parameters)
        yield from lines


def _held_lines(body: DeckBody) -> Iterator[str]:
    dim = body.mesh.dim
    for spec in body.spec.supports:
        name, held = set_name(f"{body.name}.{spec.surface}"), spec.support().components
        if _is_whole(spec, dim):
            yield f"{name}, 1, {dim}"
        else:
            yield from (f"{name}, {i + 1}, {i + 1}" for i in sorted(set(held or range(dim))))


def held_directions(body: DeckBody) -> Floats:
    """Unit vectors that components 1, 2, 3 of each node mean, (n_nodes, 3, 3)."""
    directions = np.broadcast_to(np.eye(3), (len(body.mesh.points), 3, 3)).copy()
    x = np.zeros((len(body.mesh.points), 3))
    x[:, : body.mesh.dim] = body.mesh.points
    for frame in local_frames(body):
        directions[frame.nodes] = frame.directions(x[frame.nodes])
    return directions


def displacement_lines(body: DeckBody, vectors: Floats) -> list[str]:
    """A line for each component of vectors at all nodes, (n_nodes, 3), in the frame of each."""
    local = np.einsum("nij,nj->ni", held_directions(body), vectors)
    count = len(local)
    nodes = np.arange(body.first_node, body.first_node + count)
    return value_lines(np.repeat(nodes, 3), np.tile([1, 2, 3], count), local.ravel())
