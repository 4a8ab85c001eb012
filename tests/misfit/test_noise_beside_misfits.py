"""A memory of noise is held against many misfits, whose sums are taken by one transform."""

import numpy as np

from springpot.misfit.floor import MisfitShapes, _along


def test_one_transform_sums_all_waves_and_humps():
    n, rng = 9, np.random.default_rng(1)
    x, products = np.arange(n) / (n - 1.0), rng.normal(size=(1, n, 2, 3))
    (waves, of_waves), *humps = _along(x[None], products, n)
    turns = np.pi * np.arange(2.0, n + 0.5, 0.5)[:, None] * x
    shapes = np.stack([np.cos(turns), np.sin(turns)], axis=1)
    np.testing.assert_allclose(
        waves[0], np.einsum("smn,nac->smac", shapes, products[0]), atol=1e-12
    )
    pairs = np.einsum("smn,stn,nab->smtab", shapes, shapes, products[0, ..., -2:])
    np.testing.assert_allclose(of_waves[0], pairs, atol=1e-12)
    assert len(humps) == 3
    for width, (sums, squares) in zip(0.25 * 0.5 ** np.arange(3), humps, strict=True):
        places = np.arange(sums.shape[1])[:, None] * width / 2.0
        shape = np.exp(-0.5 * ((x - places) / width) ** 2)
        direct = np.einsum("sn,nac->sac", shape, products[0])
        np.testing.assert_allclose(sums[0, :, 0], direct, atol=1e-3)
        direct = np.einsum("sn,nab->sab", shape**2, products[0, ..., -2:])
        np.testing.assert_allclose(squares[0, :, 0, 0], direct, atol=1e-3)


def test_a_shape_that_is_followed_explains_nothing():
    rng = np.random.default_rng(2)
    shape, rest = rng.normal(size=(2, 40))
    known = shape / np.linalg.norm(shape)
    rest -= known * (known @ rest)
    other = rng.normal(size=40)
    both = np.stack([shape, other], axis=1)
    columns = np.column_stack([rest / np.linalg.norm(rest), known])
    along, squares = (both.T @ columns)[None, :, None], (both.T @ both)[None, :, None, :, None]
    share, ranks = MisfitShapes(along, squares).explained(slice(None))
    left = other - known * (known @ other)
    assert ranks.tolist() == [1]
    np.testing.assert_allclose(share, (left @ rest) ** 2 / (left @ left) / (rest @ rest))
