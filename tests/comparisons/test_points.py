"""Points of a sweep: axes, distributions, and texts that are none."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import kstest, lognorm, norm, truncnorm

from cea.errors import InputError
from comparisons.sweep.points import read_distribution, read_fields, table_of


@pytest.mark.parametrize(
    ("text", "law"),
    [
        ("mu~normal:0.4:0.05", norm(0.4, 0.05)),
        ("mu~normal:0.1:0.1:0:0.2", truncnorm(-1, 1, 0.1, 0.1)),
        ("P~lognormal:1e9:0.5", lognorm(0.5, scale=1e9)),
    ],
)
def test_samples_follow_their_distribution(text, law):
    """Kolmogorov and Smirnov, whose statistic is no chance at this seed."""
    values = drawn(text)[:, 0]
    assert kstest(values, law.cdf).pvalue > 0.01
    shifted = replace(read_distribution(text), first=1.3 * read_distribution(text).first)
    assert kstest(table_of([shifted], [0.0], 5000, 11).values[:, 0], law.cdf).pvalue < 1e-6


def drawn(*texts, seed=11):
    return table_of(read_fields(texts), [0.0] * len(texts), 5000, seed).values


def test_fields_are_drawn_independently_and_by_their_seed():
    both = ("mu~uniform:0:1", "P~uniform:2:3")
    values = drawn(*both)
    assert abs(np.corrcoef(values.T)[0, 1]) < 0.05
    assert values[:, 1].min() >= 2
    np.testing.assert_array_equal(drawn(*both), values)
    assert (drawn(*both, seed=1) != values).any()


def test_what_a_field_may_not_have_is_cut_off_and_told():
    """A sixth of a normal distribution lies more than one deviation below its mean."""
    points = table_of(read_fields(["mu~normal:0.1:0.1", "P~uniform:-1:3"]), [0.0, 0.0], 5000, 2)
    assert points.cut == pytest.approx((norm.cdf(-1), 0.25))
    assert points.values.min() >= 0
    assert kstest(points.values[:, 0], truncnorm(-1, np.inf, 0.1, 0.1).cdf).pvalue > 0.01


@pytest.mark.parametrize(
    ("told", "texts"),
    {
        "first:last:count": "mu mu=0 mu=0:1 mu=0:1:x mu=a:1:3 =0:1:3 mu=0:1:lin:3 mu=0:1:3:4:5",
        "name~normal": "mu~ mu~gamma:1:2 mu~normal:1 mu~uniform:0:1:0:1 ~normal:0:1 mu~normal:a:1",
        "another last value": "mu=0:0:3",
        "2 to": "mu=0:1:1",
        "finite": "mu=0:inf:3 mu~normal:inf:1",
        "positive": "mu=0:1:log:3",
        "positive deviation": "mu~normal:0.4:0",
        "greater than 1": "mu~uniform:1:1",
        "positive, at least 1e-30": "mu~lognormal:-1:1",
        "greater than 2": "mu~normal:0:1:2:1",
        "between them": "mu~normal:0:1:50:51",
        "1e[+-]30": "mu=0:1e308:3 P=1e-31:1.0:log:3 mu=0:nan:3",
    }.items(),
)
def test_texts_that_are_no_field_are_refused(told, texts):
    for text in texts.split():
        with pytest.raises(InputError, match=told):
            read_fields([text])
