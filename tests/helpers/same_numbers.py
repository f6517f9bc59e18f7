"""Plain data compared number by number."""

import numpy as np
import pytest


def assert_same(found, expected, at="", *, rel=1e-9):
    """Equal structure, equal words, numbers equal relative to the largest beside them."""
    assert type(found) is type(expected), at
    if isinstance(expected, dict):
        assert found.keys() == expected.keys(), at
        for key in expected:
            assert_same(found[key], expected[key], f"{at}.{key}", rel=rel)
    elif isinstance(expected, list) and any(isinstance(e, dict | str) for e in expected):
        assert len(found) == len(expected), at
        for i, pair in enumerate(zip(found, expected, strict=True)):
            assert_same(*pair, f"{at}[{i}]", rel=rel)
    elif isinstance(expected, list):
        same = np.array(found, dtype=float), np.array(expected, dtype=float)
        scale = np.abs(same[1]).max(initial=0.0, where=np.isfinite(same[1]))
        np.testing.assert_allclose(*same, rtol=0, atol=rel * scale, err_msg=at)
    elif isinstance(expected, float):
        assert found == pytest.approx(expected, rel=rel, abs=1e-14), at
    else:
        assert found == expected, at
