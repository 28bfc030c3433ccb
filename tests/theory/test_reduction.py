"""Reduced coordinates (equations 15-18 and beyond): what each method promises, on chains and on the beam rotor."""

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest
from scipy import linalg, sparse

import rbfound as rb
from rbfound.rotor import assemble

RNG = np.random.default_rng(11)
N = 14
CHAIN = rb.theory.chain(RNG.uniform(1, 3, N), RNG.uniform(2, 6, N + 1) * 1e5, RNG.uniform(10, 60, N + 1))
UNDAMPED = CHAIN.M, None, CHAIN.K
SEATS = [3, 9]
ROWS = np.eye(N)[SEATS]
OMEGA = rb.theory.normal_modes(CHAIN.M, CHAIN.K)[0]
METHODS = {
    "guyan": lambda M, C, K, at: rb.theory.guyan(M, C, K, at),
    "dynamic": lambda M, C, K, at: rb.theory.dynamic_reduction(M, C, K, at, 37.0),
    "craig-bampton": lambda M, C, K, at: rb.theory.craig_bampton(M, C, K, at, 4),
    "modal": lambda M, C, K, at: rb.theory.modal_reduction(M, C, K, at, 5),
    "modal and static": lambda M, C, K, at: rb.theory.modal_reduction(M, C, K, at, 5, static=True),
}


def full(frequency, system: rb.System = CHAIN, rows=ROWS) -> np.ndarray:
    return system.receptance(frequency, rows, rows.T)


def test_guyan_is_equation_16() -> None:
    reduction = rb.theory.guyan(*UNDAMPED, SEATS)
    slaves = np.delete(np.arange(N), SEATS)
    expected = -linalg.solve(CHAIN.K[np.ix_(slaves, slaves)], CHAIN.K[np.ix_(slaves, SEATS)])
    np.testing.assert_allclose(reduction.T[slaves], expected, atol=1e-12)
    np.testing.assert_allclose(reduction.T[SEATS], np.eye(2), atol=1e-12)


def test_dynamic_reduction_is_equation_18() -> None:
    reduction = rb.theory.dynamic_reduction(*UNDAMPED, SEATS, 30.0)
    D = CHAIN.K - rb.from_hertz(30.0) ** 2 * CHAIN.M
    slaves = np.delete(np.arange(N), SEATS)
    expected = -linalg.solve(D[np.ix_(slaves, slaves)], D[np.ix_(slaves, SEATS)])
    np.testing.assert_allclose(reduction.T[slaves], expected, atol=1e-10)
    # equation 17 with its stiffness: nothing is left on the slaves
    assert np.abs((D @ reduction.T)[slaves]).max() < 1e-10 * np.abs(D).max()


@pytest.mark.parametrize("name", METHODS)
def test_the_reduced_matrices_are_those_of_the_basis(name: str) -> None:
    r = METHODS[name](CHAIN.M, CHAIN.C, CHAIN.K, SEATS)
    for small, big in ((r.M, CHAIN.M), (r.C, CHAIN.C), (r.K, CHAIN.K)):
        np.testing.assert_allclose(small, r.T.T @ big @ r.T, atol=1e-12 * np.abs(small).max())
    np.testing.assert_allclose(r.B, r.T[SEATS])


@pytest.mark.parametrize("name", ["guyan", "craig-bampton", "modal and static"])
def test_with_static_shapes_it_is_exact_at_0_hz(name: str) -> None:
    np.testing.assert_allclose(METHODS[name](*UNDAMPED, SEATS).receptance(0.0), full(0.0), rtol=1e-10)


def test_plain_modes_are_too_stiff_at_0_hz_by_what_the_omitted_ones_give() -> None:
    missing = full(0.0)[0] - METHODS["modal"](*UNDAMPED, SEATS).receptance(0.0)[0]
    omega, Phi = rb.theory.normal_modes(CHAIN.M, CHAIN.K)
    omitted = Phi[SEATS, 5:] / omega[5:]
    np.testing.assert_allclose(missing, omitted @ omitted.T, rtol=1e-8)


def test_dynamic_reduction_is_exact_at_its_frequency_and_guyan_at_0_hz_to_second_order() -> None:
    undamped = rb.System(CHAIN.M, 0 * CHAIN.M, CHAIN.K)
    at = 37.0
    reduction = METHODS["dynamic"](*UNDAMPED, SEATS)
    np.testing.assert_allclose(reduction.receptance(at), full(at, undamped), rtol=1e-9)
    # the error grows with the square of omega^2 - omega_0^2: a hundredth of the distance, a ten-thousandth of it
    for r, centre in ((reduction, rb.from_hertz(at) ** 2), (rb.theory.guyan(*UNDAMPED, SEATS), 0.0)):
        step = 0.02 * OMEGA[0] ** 2
        near, far = (rb.hertz(np.sqrt(centre + step * part)) for part in (0.1, 1.0))
        errors = [np.abs(np.linalg.inv(r.receptance(f)) - np.linalg.inv(full(f, undamped))).max() for f in (near, far)]
        assert 1.8 < np.log10(errors[1] / errors[0]) < 2.2


def test_dynamic_reduction_at_a_natural_frequency_keeps_it() -> None:
    for k in (0, 4, 9):
        r = rb.theory.dynamic_reduction(*UNDAMPED, SEATS, rb.hertz(OMEGA[k]))
        own = rb.theory.normal_modes(r.M, r.K)[0]
        assert np.abs(own / OMEGA[k] - 1).min() < 1e-8


def test_craig_bampton_comes_from_above_and_never_turns_back() -> None:
    counts = range(N - 1)
    found = [
        rb.theory.normal_modes(r.M, r.K)[0] for r in (rb.theory.craig_bampton(*UNDAMPED, SEATS, k) for k in counts)
    ]
    for count, omega in zip(counts, found, strict=True):
        assert (omega >= OMEGA[: count + 2] * (1 - 1e-10)).all()
    for fewer, more in pairwise(found):
        assert (more[: len(fewer)] <= fewer * (1 + 1e-10)).all()
    # all modes of the held body: nothing was left out
    np.testing.assert_allclose(found[-1], OMEGA, rtol=1e-9)


def test_craig_bampton_without_modes_is_guyan_and_its_first_coordinates_are_the_interface() -> None:
    np.testing.assert_allclose(rb.theory.craig_bampton(*UNDAMPED, SEATS, 0).K, rb.theory.guyan(*UNDAMPED, SEATS).K)
    r = METHODS["craig-bampton"](*UNDAMPED, SEATS)
    np.testing.assert_allclose(r.B, np.eye(2, 6), atol=1e-12)
    # static shapes and held modes do no work on each other
    np.testing.assert_allclose(r.K[:2, 2:], 0, atol=1e-9 * np.abs(r.K).max())


def test_modes_keep_their_frequencies() -> None:
    r = METHODS["modal"](*UNDAMPED, SEATS)
    np.testing.assert_allclose(r.natural_frequency, rb.hertz(OMEGA[:5]), rtol=1e-10)
    r = METHODS["modal and static"](*UNDAMPED, SEATS)
    np.testing.assert_allclose(rb.theory.normal_modes(r.M, r.K)[0][:5], OMEGA[:5], rtol=1e-9)


@pytest.mark.parametrize("name", METHODS)
def test_sparse_and_dense_matrices_give_the_same_model(name: str) -> None:
    dense = METHODS[name](*UNDAMPED, SEATS)
    M, K = (sparse.csc_array(A) for A in (CHAIN.M, CHAIN.K))
    thin = METHODS[name](M, None, K, SEATS)
    np.testing.assert_allclose(thin.receptance([0.0, 20, 60]), dense.receptance([0.0, 20, 60]), rtol=1e-8)


@pytest.mark.parametrize("name", METHODS)
def test_rows_and_coordinates_name_the_same_interface(name: str) -> None:
    a, b = (METHODS[name](*UNDAMPED, at) for at in (SEATS, ROWS))
    np.testing.assert_array_equal(a.T, b.T)


def test_an_interface_may_be_a_mean_of_coordinates() -> None:
    # as the seats of a solid are: the mean over a bore
    mean = np.zeros((2, N))
    mean[0, 2:5], mean[1, 9:13] = 1 / 3, 1 / 4
    for r in (rb.theory.guyan(*UNDAMPED, mean), rb.theory.craig_bampton(*UNDAMPED, mean, 5)):
        np.testing.assert_allclose(mean @ r.T[:, :2], np.eye(2), atol=1e-12)
        np.testing.assert_allclose(mean @ r.T[:, 2:], 0, atol=1e-12)
        expected = CHAIN.receptance(0.0, mean, mean.T)
        np.testing.assert_allclose(r.receptance(0.0), expected, rtol=1e-10)
    everything = rb.theory.craig_bampton(*UNDAMPED, mean, N - 2)
    np.testing.assert_allclose(rb.theory.normal_modes(everything.M, everything.K)[0], OMEGA, rtol=1e-9)


def test_fewer_coordinates_of_one_reduction_are_the_smaller_reduction() -> None:
    big, small = (rb.theory.craig_bampton(*UNDAMPED, SEATS, k) for k in (7, 3))
    np.testing.assert_allclose(big.first(5).receptance([10.0, 50]), small.receptance([10.0, 50]), rtol=1e-9)
    with pytest.raises(ValueError, match="from 2 to 9, as there are 2 static shapes"):
        big.first(1)


@pytest.mark.parametrize("as_given", [np.asarray, sparse.csc_array], ids=["dense", "sparse"])
@pytest.mark.parametrize("name", ["craig_bampton", "modal_reduction"])
def test_any_number_of_modes_up_to_all_may_be_kept_and_cut_down_again(name: str, as_given: Callable) -> None:
    # Lanczos iteration finds fewer than all, and modes alone have no static shapes that must stay
    method, most, static = getattr(rb.theory, name), *{"craig_bampton": (N - 2, 2), "modal_reduction": (N, 0)}[name]
    M, K = as_given(CHAIN.M), as_given(CHAIN.K)
    whole = method(M, None, K, SEATS, most)
    np.testing.assert_allclose(whole.natural_frequency, rb.hertz(OMEGA), rtol=1e-9)
    for modes in range(1, most):
        few = method(M, None, K, SEATS, modes)
        cut = whole.first(static + modes)
        np.testing.assert_allclose(cut.natural_frequency, few.natural_frequency, rtol=1e-9)
        np.testing.assert_allclose(cut.receptance([0.0, 50.0]), few.receptance([0.0, 50.0]), rtol=1e-8)
    with pytest.raises(ValueError, match=f"modes = {most + 1}"):
        method(M, None, K, SEATS, most + 1)
    with pytest.raises(ValueError, match=f"from {max(static, 1)} to {N}"):
        whole.first(0)


def test_static_shapes_stay_whole_when_modes_are_taken_away() -> None:
    whole = rb.theory.modal_reduction(*UNDAMPED, SEATS, 8, static=True)
    fewer = rb.theory.modal_reduction(*UNDAMPED, SEATS, 3, static=True)
    np.testing.assert_allclose(whole.first(5).receptance([0.0, 50.0]), fewer.receptance([0.0, 50.0]), rtol=1e-9)
    np.testing.assert_allclose(whole.first(2).receptance(0.0), full(0.0), rtol=1e-10)


def test_with_every_block_of_static_answers_the_error_at_a_line_falls_by_another_power() -> None:
    # what the modes above leave out begins with (omega / omega_next)^(2 blocks) of them
    lines, errors = 0.3 * rb.hertz(OMEGA[3]), []
    for blocks in (0, 1, 2, 3):
        omega, Phi = rb.theory.ritz(CHAIN.M, CHAIN.K, ROWS.T, 3, blocks)
        np.testing.assert_allclose(omega[:3], OMEGA[:3], rtol=1e-10)
        H = rb.theory.modal_terms(lines, omega, 0.0, np.einsum("im,jm->mij", Phi[SEATS], Phi[SEATS])).sum(axis=1)
        exact = full(lines, rb.System(CHAIN.M, 0 * CHAIN.M, CHAIN.K))
        errors.append(np.abs(H - exact).max() / np.abs(exact).max())
    assert all(more < 0.1 * fewer for fewer, more in pairwise(errors))


def test_modes_that_leave_nothing_to_the_static_answers_stay_alone() -> None:
    omega, Phi = rb.theory.ritz(CHAIN.M, CHAIN.K, ROWS.T, N, blocks=2)
    assert Phi.shape == (N, N)
    np.testing.assert_allclose(omega, OMEGA, rtol=1e-10)


def test_a_damping_ratio_for_all_own_modes() -> None:
    r = METHODS["craig-bampton"](*UNDAMPED, SEATS).damped(0.03)
    np.testing.assert_allclose(rb.System(r.M, r.C, r.K).modes().damping, 0.03, rtol=1e-8)


def test_a_free_beam_is_reduced_at_its_journals_and_keeps_its_rigid_motions() -> None:
    mesh = assemble(rb.thesis.rotor(), list(rb.thesis.bearings()))
    at = [4 * mesh.node(z) + axis for z in rb.thesis.bearings() for axis in (0, 1)]
    r = rb.theory.craig_bampton(mesh.M, None, mesh.K, at, 12)
    # two translations and two tilts carry no strain: K has rank r - 4
    values = np.linalg.eigvalsh(r.K[:4, :4] / np.abs(mesh.K).max())
    assert np.abs(values).max() < 1e-10
    own = rb.hertz(rb.theory.normal_modes(mesh.M, mesh.K)[0])
    found = rb.hertz(rb.theory.normal_modes(r.M, r.K)[0])
    np.testing.assert_allclose(found[4:8], own[4:8], rtol=2e-3)
    assert (found[4:8] >= own[4:8] * (1 - 1e-9)).all()


def test_a_reduced_foundation_under_the_rotor_gives_the_frequencies_of_the_whole() -> None:
    # a chain in each direction, tied to the bearings at two masses
    K2, M2 = (linalg.block_diag(A, A) for A in (CHAIN.K * 500, CHAIN.M * 20))
    whole_rows = np.zeros((4, 2 * N))
    for seat, mass in enumerate(SEATS):
        whole_rows[2 * seat, mass] = whole_rows[2 * seat + 1, N + mass] = 1
    whole = rb.Foundation(M2, 0 * M2, K2, whole_rows)
    r = rb.theory.modal_reduction(M2, None, K2, whole_rows, 12, static=True)
    small = rb.Foundation(r.M, r.C, r.K, r.B)
    machines = [rb.mount(rb.thesis.rotor(), rb.thesis.bearings(), on=f) for f in (whole, small)]
    a, b = (m.at(0).modes().frequency[:8] for m in machines)
    # twelve modes, six in each direction: the machine below the highest of them keeps four digits
    reach = rb.hertz(rb.theory.normal_modes(M2, K2)[0][11])
    assert a[7] < 0.9 * reach
    np.testing.assert_allclose(b, a, rtol=1e-4)


def test_on_a_solid_completed_modes_are_ritzs_method_with_one_block() -> None:
    # one space, two roads: sparse matrices and minimum degree here, halves of the body and its own iteration there
    solid = pytest.importorskip("rbfound.solid.modes", reason="needs scikit-fem", exc_type=ImportError)
    body = solid.foundation_solid(grid=solid.COARSE)
    r = rb.theory.modal_reduction(body.M, None, body.K, body.B, 6, static=True)
    other = solid.reduce(body, modes=6, blocks=1)
    lines = [0.0, 100, 346, 600]
    np.testing.assert_allclose(rb.relative_error(r.damped(0.02).receptance(lines), other.frf(lines).H), 0, atol=1e-8)
    held = rb.theory.craig_bampton(body.M, None, body.K, body.B, 6)
    # Lanczos stops at the accuracy of the arithmetic: the seats of its shapes do not move
    np.testing.assert_allclose(held.B, np.eye(4, 10), atol=1e-9)
    assert (held.natural_frequency[:6] >= r.natural_frequency[:6] * (1 - 1e-9)).all()


def test_what_a_user_can_get_wrong_is_said() -> None:
    M, _, K = UNDAMPED
    with pytest.raises(ValueError, match="name coordinates from 0 to 13, each once"):
        rb.theory.guyan(M, None, K, [3, 3])
    with pytest.raises(ValueError, match="name coordinates from 0 to 13, each once"):
        rb.theory.guyan(M, None, K, [14])
    with pytest.raises(ValueError, match=r"shape \(2, 3\)"):
        rb.theory.guyan(M, None, K, np.ones((2, 3)))
    with pytest.raises(ValueError, match="a row stands twice"):
        rb.theory.guyan(M, None, K, ROWS[[0, 0]])
    with pytest.raises(ValueError, match="K is"):
        rb.theory.guyan(M, None, K + np.triu(K), SEATS)
    with pytest.raises(ValueError, match="the body has 12"):
        rb.theory.craig_bampton(M, None, K, SEATS, 13)
    with pytest.raises(ValueError, match="from 1 to 14"):
        rb.theory.modal_reduction(M, None, K, SEATS, 0)
    with pytest.raises(ValueError, match="14 modes leave nothing to complete"):
        rb.theory.modal_reduction(M, None, K, SEATS, 14, static=True)
    free = rb.theory.chain([1.0] * 5, [0, 1e5, 1e5, 1e5, 1e5, 0])
    for A in (free.K, sparse.csc_array(free.K)):
        with pytest.raises(ValueError, match="move freely"):
            rb.theory.modal_reduction(A * 0 + np.eye(5), None, A, [0], 2, static=True)
    rest = np.ix_(*[np.delete(np.arange(N), 3)] * 2)
    held = rb.theory.normal_modes(M[rest], K[rest])[0]
    with pytest.raises(ValueError, match="held body resonates"):
        rb.theory.dynamic_reduction(M, None, K, [3], rb.hertz(held[2]))
