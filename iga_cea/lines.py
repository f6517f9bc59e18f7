"""Univariate basis of a patch at Gauss points, the factors of tensor products.

Function i is tabulated on its *window*, the degree + 1 spans that may lie in its support (all spans
if there are fewer). Its partners are the functions i + o with offsets o = -degree .. degree.
Products of i and its partners form a full array over offsets and points of the window, with zeros
where a partner or span does not exist.

Parameters are scaled by the mean span, so that slopes along different ones are comparable.
"""

from dataclasses import dataclass

import numpy as np

from cea.arrays import Floats, Ints
from iga_cea.patch import Patch
from iga_cea.splines import basis_functions, gauss_rule


@dataclass(frozen=True)
class Line:
    """Functions of one parameter and their slopes at the Gauss points."""

    degree: int
    functions: int  # number of functions
    first: Ints  # first function on each span, shape (spans,)
    # values and slopes of the functions of each span, (2, spans, points, degree + 1)
    tables: Floats
    weights: Floats  # Gauss weights, (spans, points)

    @classmethod
    def of(cls, patch: Patch, axis: int, weights: Floats | None = None) -> "Line":
        """Return the basis along one parameter of a patch, rational with weights."""
        degree, first = patch.degrees[axis], patch.first_functions[axis]
        x, rule = gauss_rule(patch.breaks[axis], degree + 1)
        _, tables = basis_functions(patch.knots[axis], degree, x.ravel(), slopes=True)
        breaks = patch.breaks[axis]
        span = (breaks[-1] - breaks[0]) / (len(breaks) - 1)
        tables = tables.reshape(2, *x.shape, degree + 1)
        tables[1] *= span
        rule /= span
        if weights is not None:
            weighted = tables * weights[first[:, None] + np.arange(degree + 1)][:, None]
            total = weighted.sum(axis=-1, keepdims=True)
            values = weighted[0] / total[0]
            tables = np.stack([values, (weighted[1] - values * total[1]) / total[0]])
        return cls(degree, patch.shape[axis], first, tables, rule)

    @classmethod
    def trivial(cls) -> "Line":
        """Return the third parameter in 2D: one function, equal to 1."""
        one = np.ones((1, 1))
        tables = np.stack([one, np.zeros((1, 1))])[..., None]
        return cls(0, 1, np.zeros(1, dtype=np.int64), tables, one)

    @property
    def spans(self) -> int:
        """Number of spans."""
        return len(self.first)

    @property
    def points(self) -> int:
        """Number of Gauss points per span."""
        return self.weights.shape[1]

    @property
    def offsets(self) -> int:
        """Number of partners of a function, including nonexistent ones."""
        return 2 * self.degree + 1

    @property
    def window(self) -> int:
        """Number of spans in a window."""
        return min(self.degree + 1, self.spans)

    @property
    def starts(self) -> Ints:
        """First span of the window of each function, shape (functions,)."""
        last = np.searchsorted(self.first, np.arange(self.functions), side="right") - 1
        return np.maximum(last - self.window + 1, 0)

    @property
    def coupled(self) -> np.ndarray:
        """True where function i shares a span with function i + o, shape (functions, offsets)."""
        coupled = np.zeros((self.functions, self.offsets), dtype=bool)
        local = np.arange(self.degree + 1)
        for a in local:
            coupled[self.first[:, None] + a, local - a + self.degree] = True
        return coupled

    def matrices(self, spans: slice) -> tuple[Floats, Floats]:
        """Return functions and their slopes at the points of spans, (points, functions) each."""
        first, tables = self.first[spans], self.tables[:, spans]
        whole = np.zeros((*tables.shape[:3], self.functions))
        columns = first[:, None, None] + np.arange(self.degree + 1)
        np.put_along_axis(whole, np.broadcast_to(columns, tables.shape), tables, axis=3)
        values, slopes = whole.reshape(2, -1, self.functions)
        return values, slopes

    def pairs(self, left: int, right: int, functions: slice) -> Floats:
        """Return products of functions and their partners, times the Gauss weights.

        Shape (functions, offsets, points of a window).
        """
        i = np.arange(self.functions)[functions]
        span = self.starts[functions][:, None] + np.arange(self.window)

        def at(derivative: int, function: Ints, span: Ints) -> Floats:
            """Return a derivative of functions on spans, zero outside supports, (..., points)."""
            local = function - self.first[span]
            inside = (local >= 0) & (local <= self.degree)
            values = self.tables[derivative, span, :, np.where(inside, local, 0)]
            return values * inside[..., None]

        partner = i[:, None, None] + np.arange(self.offsets)[:, None] - self.degree
        own = at(left, i[:, None], span) * self.weights[span]
        products = own[:, None] * at(right, partner, span[:, None])
        return products.reshape(len(i), self.offsets, -1)
