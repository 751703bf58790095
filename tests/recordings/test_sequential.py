"""Lag-sequential statistics against published tables and other packages."""

import numpy as np
import pytest
from codings import dyad
from scipy import optimize, stats

from jointattn_mj.errors import SeriesError
from jointattn_mj.recordings.sequential import LagTable, SequentialOptions, lag_table
from jointattn_mj.recordings.steps import Recordings

CLASSROOM = "214334342144541345322141252123314414133315211314123345523352544231552213333"
"""A pupil's activities: chat, write, read, ask, attentive; Bakeman and Quera (2011), p. 159."""
ACTIVITIES = ("chat", "write", "read", "ask", "attentive")


def table(counts, possible=None):
    counts = np.array(counts)
    labels = [tuple(f"{axis}{i}" for i in range(n)) for axis, n in zip("gt", counts.shape, strict=True)]
    return LagTable(*labels, counts, np.ones(counts.shape, bool) if possible is None else possible)


def recordings(labels, *parts, groups=None, **more):
    columns = {"who": [np.array(part) for part in parts], **more}
    return Recordings(columns, dict.fromkeys(columns, labels), groups or list(range(len(parts))), 0)


@pytest.fixture
def classroom():
    return recordings(ACTIVITIES, [int(digit) - 1 for digit in CLASSROOM])


def test_adjusted_residuals_of_a_published_table():
    """Sex and party in 1991: Agresti (2007), An Introduction to Categorical Data Analysis, tables 2.5 and 2.6."""
    found = table([[762, 327, 468], [484, 239, 477]])
    assert found.adjusted_residuals[0].round(2).tolist() == [4.50, 0.70, -5.32]
    assert found.expected[0].round(1).tolist() == [703.7, 319.6, 533.7]
    pearson, likelihood = found.chi_squared
    assert (round(pearson, 1), round(likelihood, 1), found.degrees_of_freedom) == (30.1, 30.0, 2)


def test_odds_ratio_of_a_published_table():
    """Hay fever and eczema: Bland and Altman (2000), The odds ratio, BMJ 320, 1468."""
    found = table([[141, 420], [928, 13525]])
    low, high = found.odds_ratio_interval
    assert [round(float(x[0, 0]), 2) for x in (found.odds_ratio, low, high)] == [4.89, 4.00, 5.99]
    assert found.yules_q[0, 0] == pytest.approx((4.8928 - 1) / (4.8928 + 1), abs=1e-4)
    assert found.yules_q[0, 1] == -found.yules_q[0, 0]


def test_of_published_codes(classroom):
    """75 activities have 74 transitions; two-by-two tables of each pair have Pearson's residual as theirs."""
    found = lag_table(classroom, "who", "who")
    assert (found.total, found.counts.tolist()[0]) == (74, [1, 3, 4, 6, 2])
    for i in range(5):
        for j in range(5):
            a = found.counts[i, j]
            b, c = found.counts[i].sum() - a, found.counts[:, j].sum() - a
            chi = stats.chi2_contingency([[a, b], [c, 74 - a - b - c]], correction=False)[0]
            assert found.adjusted_residuals[i, j] ** 2 == pytest.approx(chi)
    assert np.allclose(found.p, 2 * stats.norm.sf(abs(found.adjusted_residuals)))
    assert np.allclose(found.conditional.sum(1), 1)


def test_structural_zeros(classroom):
    """What cannot follow itself: fitted margins, and residuals of the log-linear model fitted by another way."""
    found = lag_table(classroom, "who", "who", SequentialOptions(unit="events"))
    assert (np.diag(found.counts) == 0).all()
    assert np.isnan(np.diag(found.adjusted_residuals)).all()
    assert np.allclose(found.expected.sum(0), found.counts.sum(0))
    assert found.degrees_of_freedom == 11
    i, j = np.nonzero(found.possible)
    design = np.hstack([np.eye(5)[i], np.eye(5)[j][:, 1:]])
    observed = found.counts[i, j]
    fit = optimize.minimize(lambda b: np.exp(design @ b).sum() - observed @ (design @ b), np.zeros(9), method="BFGS")
    expected = np.exp(design @ fit.x)
    assert np.allclose(found.expected[i, j], expected, atol=1e-3)
    information = design.T @ (expected[:, None] * design)
    leverage = expected * np.einsum("ij,jk,ik->i", design, np.linalg.inv(information), design)
    residuals = (observed - expected) / np.sqrt(expected * (1 - leverage))
    assert np.allclose(found.adjusted_residuals[i, j], residuals, atol=1e-3)
    with pytest.raises(SeriesError, match="occurred 6 times"):
        lag_table(classroom, "who", "who", impossible=[("chat", "ask")])
    assert not lag_table(classroom, "who", "who", impossible=[("write", "ask")]).possible[1, 3]


def test_units_of_counting():
    looks = recordings(
        ("face", "toy"), [0, 0, 1, 1, 1, 0], [1, 0], infant=[np.array([1, 1, 1, 1, 0, 0]), np.array([0, 0])]
    )
    assert lag_table(looks, "who", "who").counts.tolist() == [[1, 1], [2, 2]]
    assert lag_table(looks, "who", "who", SequentialOptions(unit="events")).counts.tolist() == [[0, 1], [2, 0]]
    assert lag_table(looks, "infant", "who", SequentialOptions(unit="onsets")).counts.tolist() == [[2, 0], [0, 1]]
    assert lag_table(looks, "infant", "who", SequentialOptions(lag=0)).counts.tolist() == [[2, 2], [2, 2]]
    with pytest.raises(SeriesError, match="one tier"):
        lag_table(looks, "infant", "who", SequentialOptions(unit="events"))
    with pytest.raises(SeriesError, match="shorter lag"):
        lag_table(looks, "infant", "who", SequentialOptions(lag=9))
    with pytest.raises(SeriesError, match="no variable 'mother'"):
        lag_table(looks, "mother", "who")


def test_empty_counts_are_no_numbers_and_no_errors():
    found = table([[0, 0], [3, 5]])
    assert np.isnan(found.conditional[0]).all()
    assert np.isnan(found.odds_ratio).all()
    certain = table([[4, 0], [0, 4]])
    assert certain.odds_ratio[0].tolist() == [float("inf"), 0]
    assert np.isfinite(certain.odds_ratio_interval).all()
    assert len(certain.rows()) == 4


def test_shifts_hold_where_looks_are_long():
    """Residuals of unrelated partners call too much significant, shifts do not."""
    residual = shift = 0
    for seed in range(30):
        own, partner = dyad(np.random.default_rng(seed), 1.5, 0)
        both = recordings(("a", "b", "c"), own, infant=[partner])
        found = lag_table(both, "who", "infant", SequentialOptions(surrogates=99))
        residual += (found.p <= 0.05).sum()
        shift += (found.p_shift <= 0.05).sum()
    assert residual > 150
    assert shift <= 35
    own, partner = dyad(np.random.default_rng(1), 1, 0.8)
    found = lag_table(recordings(("a", "b", "c"), own, infant=[partner]), "who", "infant", SequentialOptions(lag=9))
    assert (np.diag(found.p_shift) < 0.01).all()
    assert "p_shift" in found.rows()[0]
