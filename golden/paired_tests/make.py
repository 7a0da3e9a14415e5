# requirements: numpy, scipy, statsmodels (versions used stand in the file it writes)
"""Writes golden.json: paired tests, corrections, intervals and quantiles by scipy and statsmodels.

Run in this folder: python3 make.py
"""
import json
import sys
from types import SimpleNamespace

import numpy as np
import scipy
import statsmodels
from scipy import stats
from statsmodels.stats.multitest import multipletests
from statsmodels.stats.weightstats import ttost_paired

rng = np.random.default_rng(11)
ALTERNATIVES = ("two-sided", "less", "greater")


def signed_rank(d, method, **keywords):
    found = {a: float(stats.wilcoxon(d, alternative=a, method=method, **keywords).pvalue) for a in ALTERNATIVES}
    nonzero = d[d != 0]
    ranks = stats.rankdata(np.abs(nonzero))
    return {"d": d.tolist(), "w_plus": float(ranks[nonzero > 0].sum()), "w_minus": float(ranks[nonzero < 0].sum()), "p": found}


def all_signs(d):
    """Every assignment of signs, counted one by one: exact with ties."""
    d = d[d != 0]
    n = len(d)
    ranks = stats.rankdata(np.abs(d))
    signs = (np.arange(2**n)[:, None] >> np.arange(n)) & 1
    w = signs @ ranks
    observed = ranks[d > 0].sum()
    less, greater = np.mean(w <= observed + 1e-9), np.mean(w >= observed - 1e-9)
    return {"two-sided": float(min(1, 2 * min(less, greater))), "less": float(less), "greater": float(greater)}


eleven = rng.normal(0.3, 1.0, 11)
tied = np.round(rng.normal(0.4, 1.0, 12), 0)
tied_less = np.round(rng.normal(-0.3, 1.0, 15) * 2) / 2
large = rng.normal(0.15, 1.0, 40)
large_tied = np.round(rng.normal(0.2, 1.0, 60), 1)
exact = [signed_rank(x, "exact") for x in (eleven, np.array([0.5]), rng.normal(-0.2, 1, 20), rng.normal(0.1, 1, 25))]
counted = []
for x in (tied, tied_less):
    row = signed_rank(x, "approx")
    row["p"] = all_signs(x)
    counted.append(row)
normal = [signed_rank(x, "approx", correction=True) for x in (large, large_tied)]

holm = []
for p in ([0.01, 0.04, 0.03, 0.005], [0.5], [0.2, 0.2, 0.9, 0.001, 0.04, 0.04], rng.uniform(0, 0.2, 9).tolist()):
    holm.append({"p": p, "adjusted": multipletests(p, method="holm")[1].tolist()})

equivalence = []
for centre, spread, margin in ((0.0, 0.05, 0.1), (0.08, 0.05, 0.1), (-0.15, 0.05, 0.1), (0.02, 0.3, 0.2)):
    d = rng.normal(centre, spread, 11)
    p, (_, p_low, _), (_, p_high, _) = ttost_paired(d, np.zeros(11), -margin, margin)
    shifted = [
        float(stats.wilcoxon(d + margin, alternative="greater", method="exact").pvalue),
        float(stats.wilcoxon(d - margin, alternative="less", method="exact").pvalue),
    ]
    equivalence.append({
        "d": d.tolist(), "margin": margin, "p_t": float(p), "p_t_low": float(p_low), "p_t_high": float(p_high),
        "p_rank_low": shifted[0], "p_rank_high": shifted[1],
    })

walsh = []
for x in (eleven, large, tied):
    i, j = np.triu_indices(len(x))
    walsh.append({"d": x.tolist(), "estimate": float(np.median((x[i] + x[j]) / 2))})


def bootstrap(name, samples, statistic, resamples=999):
    """The intervals that scipy makes of one set of resamples; the resamples themselves go into the file."""
    n = len(samples[0])
    index = rng.integers(0, n, (resamples, n))
    distribution = np.array([statistic(*(x[i] for x in samples), axis=-1) for i in index])
    row = {"name": name, "samples": [x.tolist() for x in samples], "distribution": distribution.tolist(),
           "observed": float(statistic(*samples, axis=-1))}
    for method in ("percentile", "BCa"):
        for level in (0.9, 0.95):
            interval = stats.bootstrap(
                samples, statistic, n_resamples=0, method=method, confidence_level=level, paired=True, vectorized=True,
                bootstrap_result=SimpleNamespace(bootstrap_distribution=distribution),
            ).confidence_interval
            row[f"{method.lower()}_{round(100 * level)}"] = [float(interval.low), float(interval.high)]
    return row


def ratio(a, b, axis):
    return np.mean(a, axis=axis) / np.mean(b, axis=axis)


a = rng.lognormal(-2, 0.6, 11)
b = a * rng.lognormal(0.1, 0.2, 11)
resampled = [bootstrap("median", (a,), np.median), bootstrap("ratio of means", (a, b), ratio)]

quantiles = [
    {"dof": dof, "confidence": c, "low": float(stats.chi2.ppf((1 - c) / 2, dof)), "high": float(stats.chi2.ppf((1 + c) / 2, dof))}
    for dof in (1, 3, 6, 30, 150, 300, 1500, 100000) for c in (0.95, 0.99)
]

with open("golden.json", "w") as out:
    json.dump({
        "versions": {"python": sys.version.split()[0], "numpy": np.__version__, "scipy": scipy.__version__,
                     "statsmodels": statsmodels.__version__},
        "signed_rank": {"exact": exact, "counted": counted, "normal": normal},
        "holm": holm, "equivalence": equivalence, "hodges_lehmann": walsh, "bootstrap": resampled, "chi_square": quantiles,
    }, out)
    out.write("\n")
