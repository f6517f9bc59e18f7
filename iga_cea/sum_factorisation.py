"""Bilinear forms on a patch by sum factorisation: matrix rows of a box of functions.

    A[i a, j b] = sum_km int C_km[ab] D_k N_i D_m N_j dxi,    i = i1 i2 i3,  D_0 .. D_2 slopes,

is contracted one parameter at a time, the third first (Antolin, Buffa, Calabro, Martinelli &
Sangalli, Efficient matrix computation for tensor-product isogeometric analysis, 2015), each time by
one matrix product of all functions' products with partners and the points of their windows. Rows
are computed in slabs of equal i1. What the slabs of a box share is stored either at few points of
the first parameter, if the coefficients are separable (:mod:`iga_cea.separation`), or at the points
of a moving window.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from cea.arrays import Floats, chunks
from iga_cea.lines import Line
from iga_cea.metric import Map, Metric
from iga_cea.separation import Coefficients, Kind, Separation, holds, kind_of, separate

Box = tuple[slice, slice, slice]
"""Functions of a patch along each parameter."""

_SAMPLES = 5
"""Points along a parameter in the first test whether coefficients are separable."""


@dataclass(frozen=True)
class Form:
    """A bilinear form."""

    components: int  # components of each function: 1, or dim
    # C_km times the Jacobian from the metric; those of (m, k) are the transposes of those of
    # (k, m), up to a common sign
    coefficients: Callable[[Metric], Coefficients]
    # coefficients of an additional field, one row per scalar dof
    field: Floats | None = None


def slabs(
    patch_map: Callable[[list[tuple[Floats, Floats]]], Map],
    lines: list[Line],
    form: Form,
    box: Box,
) -> Iterator[tuple[int, slice, Floats]]:
    """Yield the rows of the functions of a box in slabs.

    A slab has i1, functions along the second parameter, and entries, (functions of the slab,
    components of the row, offsets, components of the column).
    """
    columns = form.components**2 * np.prod([line.offsets for line in lines[1:]])
    of_window = 4 * lines[0].window * lines[0].points
    of_each = 8 * columns * (box[2].stop - box[2].start) * of_window
    # Separable coefficients need at most about a fourth of the memory of a window.
    for wide in _cut(box[1], of_each / 4):
        work = _Box(patch_map, lines, form, (box[0], wide, box[2]))
        few = work.separable()
        if few is not None:
            for i, slab in work.separated(*few):
                yield i, wide, slab
            continue
        for part in _cut(wide, of_each):
            work = _Box(patch_map, lines, form, (box[0], part, box[2]))
            for i, slab in work.moving():
                yield i, part, slab


def _cut(whole: slice, bytes_each: float) -> Iterator[slice]:
    """Divide functions into chunks of bounded memory."""
    for part in chunks(whole.stop - whole.start, bytes_each):
        yield slice(whole.start + part.start, whole.start + part.stop)


class _Box:
    """Rows of the functions of a box, which share data along the first parameter."""

    def __init__(
        self,
        patch_map: Callable[[list[tuple[Floats, Floats]]], Map],
        lines: list[Line],
        form: Form,
        box: Box,
    ) -> None:
        self._lines, self._form, self._box = lines, form, box
        self._patch_map = patch_map
        self._spans = [_spans(line, part) for line, part in zip(lines, box, strict=True)]
        self._map = patch_map(
            [line.matrices(spans) for line, spans in zip(lines[1:], self._spans[1:], strict=True)]
        )

    def _layers(self) -> Iterator[tuple[int, Coefficients]]:
        """Yield the coefficients at the points of each span of the first parameter."""
        line = self._lines[0]
        for span in range(self._spans[0].start, self._spans[0].stop):
            first = int(line.first[span])
            functions = slice(first, first + line.degree + 1)
            metric = self._map.at(line.tables[0, span], line.tables[1, span], functions)
            yield span, self._form.coefficients(metric)

    def separable(self) -> tuple[dict[Kind, Separation], Coefficients] | None:
        """Return separations, and the coefficients at their rows; None if not separable."""
        line, spans = self._lines[0], self._spans[0]
        values, slopes = line.matrices(spans)
        few = []
        for other, part in zip(self._lines[1:], self._spans[1:], strict=True):
            along, rates = other.matrices(part)
            at = np.unique(np.linspace(0, len(along) - 1, _SAMPLES).astype(int))
            few.append((along[at], rates[at]))
        sample = self._form.coefficients(self._patch_map(few).at(values, slopes))
        kinds = {kind_of(*pair) for pair in sample}
        found = separate(sample, len(kinds) * line.window * line.points // 2)
        if found is None:
            return None
        rows = np.unique(np.concatenate([s.rows for s in found.values()]))
        every = self._form.coefficients(self._map.at(values[rows], slopes[rows]))
        skeleton = {
            pair: c[:, np.searchsorted(rows, found[kind_of(*pair)].rows)]
            for pair, c in every.items()
        }
        layers = (
            (slice((s - spans.start) * line.points, (s - spans.start + 1) * line.points), c)
            for s, c in self._layers()
        )
        steepness = max(other.degree * other.spans for other in self._lines)
        return (found, skeleton) if holds(found, skeleton.__getitem__, layers, steepness) else None

    def separated(
        self, found: dict[Kind, Separation], skeleton: Coefficients
    ) -> Iterator[tuple[int, Floats]]:
        """Yield rows from the selected points of separable coefficients."""
        line, functions = self._lines[0], self._box[0]
        across = self._across(skeleton)
        kinds = sorted(across)
        held = np.concatenate([across[kind] for kind in kinds])
        first = (line.starts[functions] - self._spans[0].start) * line.points
        points = first[:, None] + np.arange(line.window * line.points)
        along = np.concatenate(
            [line.pairs(*kind, functions) @ found[kind].factors[points] for kind in kinds], axis=2
        )
        for i, pairs in enumerate(along):
            yield functions.start + i, _rows(pairs, held, self._form.components)

    def moving(self) -> Iterator[tuple[int, Floats]]:
        """Yield rows from a moving window, in which span s is stored at s modulo its length."""
        line, functions = self._lines[0], self._box[0]
        starts, done = line.starts, self._spans[0].start
        layers = self._layers()
        kinds: list[Kind] = []
        held: Floats = np.empty(0)
        along: Floats = np.empty(0)
        for i in range(functions.start, functions.stop):
            while done < starts[i] + line.window:
                span, coefficients = next(layers)
                across = self._across(coefficients)
                if not kinds:
                    kinds = sorted(across)
                    shape = (len(kinds), line.window, *across[kinds[0]].shape)
                    held = np.empty(shape)
                    along = np.stack([line.pairs(*kind, functions) for kind in kinds], axis=2)
                    along = along.reshape(*along.shape[:3], line.window, line.points)
                for k, kind in enumerate(kinds):
                    held[k, span % line.window] = across[kind]
                done += 1
            pairs = np.roll(along[i - functions.start], starts[i] % line.window, axis=2)
            flat = held.reshape(-1, *held.shape[3:])
            yield i, _rows(pairs.reshape(len(pairs), -1), flat, self._form.components)

    def _across(self, coefficients: Coefficients) -> dict[Kind, Floats]:
        """Contract over the third and the second parameter, in the layout of :func:`_rows`."""
        n = self._form.components
        line, functions = self._lines[2], self._box[2]
        windows = _windows(line, functions, self._spans[2].start)
        count, offsets = len(windows), line.offsets
        third: dict[tuple[int, int], Floats] = {}
        for (k, m), c in coefficients.items():
            products = line.pairs(int(k == 2), int(m == 2), functions)
            _, r, points, _ = c.shape
            left = (3 if k == 2 else k), (3 if m == 2 else m)
            if left not in third:
                third[left] = np.zeros((r, points, count, n, offsets, n))
            flat = np.ascontiguousarray(c).reshape(n * n * r * points, -1)
            for i, window in enumerate(windows):
                part = (flat[:, window] @ products[i].T).reshape(n, n, r, points, offsets)
                third[left][:, :, i] += part.transpose(2, 3, 0, 4, 1)

        line, functions = self._lines[1], self._box[1]
        windows = _windows(line, functions, self._spans[1].start)
        parts: dict[Kind, list[tuple[Floats, Floats]]] = {}
        for (k, m), t in third.items():
            products = line.pairs(int(k == 1), int(m == 1), functions)
            parts.setdefault(kind_of(k, m), []).append((products, t.reshape(*t.shape[:2], -1)))
        second: dict[Kind, Floats] = {}
        for kind, pieces in parts.items():
            r = len(pieces[0][1])
            out = np.empty((r, len(windows), count * n, line.offsets, offsets * n))
            for i, window in enumerate(windows):
                whole = sum(products[i] @ t[:, window] for products, t in pieces)
                out[:, i] = whole.reshape(r, line.offsets, count * n, -1).swapaxes(1, 2)
            second[kind] = out.reshape(r, len(windows) * count * n, -1)
        return second


def _rows(pairs: Floats, held: Floats, components: int) -> Floats:
    """Contract over the first parameter, (functions, components, offsets, components)."""
    rows = np.matmul(pairs, held.transpose(1, 0, 2))
    return rows.reshape(rows.shape[0] // components, components, -1, components)


def _spans(line: Line, functions: slice) -> slice:
    """Return the spans in the windows of functions."""
    starts = line.starts[functions]
    return slice(int(starts[0]), int(starts[-1]) + line.window)


def _windows(line: Line, functions: slice, start: int) -> list[slice]:
    """Return the points of the windows of functions, numbered from a span."""
    first = (line.starts[functions] - start) * line.points
    return [slice(int(f), int(f) + line.window * line.points) for f in first]
