"""The top of a concave function along a chain, against a general optimiser and by its conditions."""

import numpy as np
import pytest
from scipy.optimize import minimize

from tgvdp.certificate.chain import chain_of, link_gain, own_gain, solve_chain

CELLS = 4


def random_chain(seed):
    rng = np.random.default_rng(seed)
    chain = chain_of(2 * CELLS)
    chain.level[:] = -0.5, -0.2, 0.0
    chain.at[:] = rng.uniform(-1.0, 0.4, 2 * CELLS)
    chain.at[rng.random(2 * CELLS) < 0.3] = -0.5
    chain.lowest[:], chain.highest[:] = chain.at - 50.0, chain.at + 50.0
    chain.bend[:] = 1e-3
    for cell in range(CELLS):
        for u in rng.normal(size=(2, 2)) * (30.0, 10.0):
            u[0] = -u[1] + rng.normal()
            chain.bend[2 * cell : 2 * cell + 2] += u * u
            chain.link[2 * cell + 1] += u[0] * u[1]
    chain.drop[:] = rng.uniform(0.0, 2.0, (2 * CELLS, 3))
    w = rng.uniform(2.0, 6.0, CELLS + 1)
    for cell in range(CELLS):
        below = np.sum(
            chain.drop[2 * cell : 2 * cell + 2] * (chain.level[0] < chain.at[2 * cell : 2 * cell + 2, None]), 1
        )
        chain.slope[2 * cell : 2 * cell + 2] = np.array((-w[cell], w[cell + 1])) + below
    chain.slope[0] += w[0]
    chain.slope[-1] -= w[-1]
    chain.cap[2::2] = rng.uniform(0.7, 1.2, CELLS - 1) * w[1:-1]
    return chain


def value(chain, p):
    chain.best[:] = p
    total = sum(own_gain(chain, i, p[i]) for i in range(len(p)))
    total += sum(link_gain(chain, i) for i in range(1, len(p), 2))
    return total - float(chain.cap[2::2] @ np.maximum(p[1:-1:2] - p[2::2], 0.0))


@pytest.mark.nojit
@pytest.mark.parametrize("seed", range(12))
def test_no_other_values_are_better(seed):
    chain = random_chain(seed)
    solve_chain(0, 2 * CELLS - 1, 0.0, chain)
    best = chain.best.copy()
    top = value(chain, best)
    rng = np.random.default_rng(100 + seed)
    for scale in (1e-4, 1e-2, 1.0):
        for _ in range(200):
            some = best + scale * rng.normal(size=len(best)) * (rng.random(len(best)) < 0.4)
            assert value(chain, some) <= top + 1e-9 * abs(top)
    for start in (chain.at.copy(), best + 0.05):
        found = minimize(lambda p: -value(chain, p), start, method="Powell", options={"maxiter": 20000})
        assert -found.fun <= top + 1e-6 * abs(top)


@pytest.mark.nojit
def test_thinning_loses_no_more_than_it_may():
    exact = random_chain(3)
    solve_chain(0, 2 * CELLS - 1, 0.0, exact)
    top = value(exact, exact.best.copy())
    thinned = random_chain(3)
    solve_chain(0, 2 * CELLS - 1, 1e-3, thinned)
    assert top - value(thinned, thinned.best.copy()) < 0.1


@pytest.mark.nojit
@pytest.mark.parametrize("seed", range(12))
def test_an_unknown_that_goes_on_from_the_one_before_is_the_same(seed):
    chain = random_chain(seed)
    chain.cap[2::2] = np.inf
    chain.lowest[:], chain.highest[:] = -50.0, 50.0
    chain.lowest[:1] = chain.highest[:1] = chain.at[0]  # and one that is held
    solve_chain(0, 2 * CELLS - 1, 0.0, chain)
    best = chain.best.copy()
    assert (best[1:-1:2] == best[2::2]).all()
    assert best[0] == chain.at[0]
    chain.cap[2::2] = 0.0
    top = value(chain, best)
    rng = np.random.default_rng(100 + seed)
    for scale in (1e-4, 1e-2, 1.0):
        for _ in range(200):
            nodes = scale * rng.normal(size=CELLS) * (rng.random(CELLS) < 0.5)
            some = best + np.append(0.0, np.repeat(nodes, 2)[:-1])
            assert value(chain, some) <= top + 1e-9 * abs(top)
