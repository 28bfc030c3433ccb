"""The Timoshenko beam element against published coefficients and closed forms."""

import numpy as np
import pytest
from scipy import linalg

from rbfound.beam import Section, element

STUBBY = Section(diameter=0.1, inner=0.04, E=2.0e11, rho=7800.0, nu=0.28)
LENGTH = 0.12


def phi_of(length, section):
    """Shear parameter 12 E I / (kappa G A L^2)."""
    return 12 * section.E * section.inertia / (section.shear_stiffness * length**2)


def symmetric(rows):
    """The full matrix of an upper triangle, written row by row."""
    out = np.zeros((4, 4))
    for k, row in enumerate(rows):
        out[k, k:] = row
    return out + np.triu(out, 1).T


def assemble(elements, length, section):
    """M and K of one plane of a uniform beam: w, s at each node."""
    n = 2 * (elements + 1)
    M, K = np.zeros((n, n)), np.zeros((n, n))
    part = element(length / elements, section)
    for k in range(elements):
        M[2 * k : 2 * k + 4, 2 * k : 2 * k + 4] += part.M
        K[2 * k : 2 * k + 4, 2 * k : 2 * k + 4] += part.K
    return M, K


def circular_frequencies(elements, length, section, supported):
    """Natural frequencies [rad/s], simply supported at both ends or free (without the two rigid-body ones)."""
    M, K = assemble(elements, length, section)
    kept = np.delete(np.arange(len(M)), [0, len(M) - 2]) if supported else np.arange(len(M))
    values = linalg.eigvalsh(K[np.ix_(kept, kept)], M[np.ix_(kept, kept)])
    return np.sqrt(values if supported else values[2:])


# --- the section ---


def test_area_and_inertia_are_those_of_a_tube():
    # pi/4 (D^2 - d^2), pi/64 (D^4 - d^4) in decimal: D = 0.1, d = 0.04
    assert STUBBY.area == pytest.approx(6.5973446e-3, rel=1e-7)
    assert STUBBY.inertia == pytest.approx(4.7830748e-6, rel=1e-7)


def test_the_shear_coefficient_is_cowpers_for_a_solid_and_for_a_thin_tube():
    # Cowper 1966: solid circle 6 (1 + nu) / (7 + 6 nu); thin tube 2 (1 + nu) / (4 + 3 nu)
    for inner, kappa in ((0.0, 6 * 1.3 / (7 + 6 * 0.3)), (0.0999999, 2 * 1.3 / (4 + 3 * 0.3))):
        s = Section(0.1, inner)
        assert s.shear_stiffness / (s.E / 2.6 * s.area) == pytest.approx(kappa, rel=1e-5)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"diameter": 0.0}, "diameter 0 m with inner diameter 0 m: need 0 <= inner < diameter"),
        ({"diameter": 0.1, "inner": 0.1}, "inner diameter 0.1 m"),
        ({"diameter": 0.1, "inner": -0.01}, "inner diameter -0.01 m"),
        ({"diameter": float("nan")}, "diameter nan"),
        ({"diameter": 0.1, "E": 0.0}, "E = 0: it must be positive"),
        ({"diameter": 0.1, "rho": -1.0}, "rho = -1"),
        ({"diameter": 0.1, "E": float("inf")}, "E = inf"),
        ({"diameter": 0.1, "nu": 0.6}, "nu = 0.6"),
    ],
)
def test_an_impossible_section_is_an_error_with_the_number(wrong, message):
    with pytest.raises(ValueError, match=message):
        Section(**wrong)


# --- the element's matrices ---


@pytest.mark.parametrize("length", [0.03, 0.12, 3.0])
def test_the_stiffness_is_the_published_one(length):
    # E I / ((1 + phi) L^3) [12, 6L, -12, 6L; (4 + phi) L^2, -6L, (2 - phi) L^2; ...] (Friswell et al. 2010, chapter 4)
    p, L = phi_of(length, STUBBY), length
    expected = (
        STUBBY.E
        * STUBBY.inertia
        / ((1 + p) * L**3)
        * symmetric([[12, 6 * L, -12, 6 * L], [(4 + p) * L**2, -6 * L, (2 - p) * L**2], [12, -6 * L], [(4 + p) * L**2]])
    )
    np.testing.assert_allclose(element(L, STUBBY).K, expected, rtol=1e-12)


@pytest.mark.parametrize("length", [0.03, 0.12, 3.0])
def test_the_mass_is_the_published_one(length):
    # translation rho A L / (840 (1 + phi)^2) [...], rotation rho I / (30 L (1 + phi)^2) [...] (Friswell et al. 2010)
    p, L = phi_of(length, STUBBY), length
    a, b, c = 312 + 588 * p + 280 * p**2, (44 + 77 * p + 35 * p**2) * L, 108 + 252 * p + 140 * p**2
    d, e, f = -(26 + 63 * p + 35 * p**2) * L, (8 + 14 * p + 7 * p**2) * L**2, -(6 + 14 * p + 7 * p**2) * L**2
    shift = symmetric([[a, b, c, d], [e, -d, f], [a, -b], [e]])
    g, h, i = (3 - 15 * p) * L, (4 + 5 * p + 10 * p**2) * L**2, (-1 - 5 * p + 5 * p**2) * L**2
    tilt = symmetric([[36, g, -36, g], [h, -g, i], [36, -g], [h]])
    rotary = STUBBY.rho * STUBBY.inertia / (30 * L * (1 + p) ** 2) * tilt
    expected = STUBBY.rho * STUBBY.area * L / (840 * (1 + p) ** 2) * shift + rotary
    part = element(L, STUBBY)
    np.testing.assert_allclose(part.M, expected, rtol=1e-11, atol=1e-13 * np.abs(expected).max())
    # a round section's polar moment of area is twice that about a diameter
    np.testing.assert_allclose(part.G, 2 * rotary, rtol=1e-11, atol=1e-13 * np.abs(rotary).max())


def test_a_slender_element_is_the_euler_bernoulli_one():
    # rho A L / 420 [156, 22L, 54, -13L; 4L^2, 13L, -3L^2; ...] and E I / L^3 [12, 6L, -12, 6L; 4L^2, ...];
    # shear and rotary inertia are of order (d/L)^2 = 1e-8
    s, L = Section(1e-4), 1.0
    M = symmetric([[156, 22 * L, 54, -13 * L], [4 * L**2, 13 * L, -3 * L**2], [156, -22 * L], [4 * L**2]])
    K = symmetric([[12, 6 * L, -12, 6 * L], [4 * L**2, -6 * L, 2 * L**2], [12, -6 * L], [4 * L**2]])
    np.testing.assert_allclose(element(L, s).M, s.rho * s.area * L / 420 * M, rtol=1e-7)
    np.testing.assert_allclose(element(L, s).K, s.E * s.inertia / L**3 * K, rtol=1e-7)


def test_all_three_matrices_are_symmetric():
    part = element(LENGTH, STUBBY)
    for matrix in (part.M, part.K, part.G):
        np.testing.assert_allclose(matrix, matrix.T, rtol=1e-14)


def test_a_rigid_motion_costs_no_energy():
    part = element(LENGTH, STUBBY)
    for motion in ([1, 0, 1, 0], [0, 1, LENGTH, 1]):
        assert np.abs(part.K @ motion).max() < 1e-12 * np.abs(part.K).max()


def test_a_rigid_motion_feels_the_whole_mass_and_its_moments_of_inertia():
    # rho A L; about the left end rho A L^3 / 3 + rho I L; coupling rho A L^2 / 2; polar 2 rho I L
    part, s, L = element(LENGTH, STUBBY), STUBBY, LENGTH
    shift, tilt = np.array([1, 0, 1, 0]), np.array([0, 1, L, 1])
    assert shift @ part.M @ shift == pytest.approx(s.rho * s.area * L, rel=1e-12)
    assert shift @ part.M @ tilt == pytest.approx(s.rho * s.area * L**2 / 2, rel=1e-12)
    assert tilt @ part.M @ tilt == pytest.approx(s.rho * s.area * L**3 / 3 + s.rho * s.inertia * L, rel=1e-12)
    assert tilt @ part.G @ tilt == pytest.approx(2 * s.rho * s.inertia * L, rel=1e-12)
    assert np.abs(part.G @ shift).max() < 1e-12 * np.abs(part.G).max()


@pytest.mark.parametrize("elements", [1, 5])
def test_a_cantilever_bends_and_shears_as_it_should(elements):
    # tip force F: w = F L^3 / 3EI + F L / (kappa G A), slope F L^2 / 2EI: exact at the nodes for any mesh
    _, K = assemble(elements, LENGTH, STUBBY)
    force = np.zeros(len(K) - 2)
    force[-2] = 1.0
    w, slope = np.linalg.solve(K[2:, 2:], force)[-2:]
    EI = STUBBY.E * STUBBY.inertia
    assert w == pytest.approx(LENGTH**3 / (3 * EI) + LENGTH / STUBBY.shear_stiffness, rel=1e-10)
    assert slope == pytest.approx(LENGTH**2 / (2 * EI), rel=1e-10)


# --- natural frequencies ---

# roots of cos x cosh x = 1 (free-free), by Newton's method in the tables of any textbook; n pi when simply supported
FREE = np.array([4.730040744862704, 7.853204624095838, 10.995607838001671])
SUPPORTED = np.pi * np.array([1.0, 2.0, 3.0])


def test_the_free_free_numbers_solve_their_frequency_equation():
    np.testing.assert_allclose(np.cos(FREE) * np.cosh(FREE), 1.0, atol=1e-9)


@pytest.mark.parametrize(("numbers", "supported"), [(FREE, False), (SUPPORTED, True)])
@pytest.mark.parametrize("mode", [0, 1, 2])
def test_a_slender_beam_tends_to_euler_and_bernoulli_with_the_fourth_order(numbers, supported, mode):
    # omega = x^2 sqrt(EI / (rho A L^4)). Cubic shape functions: error of order h^4 in a frequency.
    # d/L = 1e-4: shear and rotary inertia take x^2/2 (d/4)^2 (1 + E / kappa G) = 1.2e-9 x^2 of a frequency, 1.3e-7 of
    # the third; the discretisation's share on the finest mesh here is more than ten times that (asserted).
    s = Section(1e-4)
    exact = numbers[mode] ** 2 * np.sqrt(s.E * s.inertia / (s.rho * s.area))
    meshes = np.array([3, 6, 12]) * (mode + 1) if supported else np.array([6, 12]) * (mode + 1)
    errors = np.array([circular_frequencies(n, 1.0, s, supported)[mode] / exact - 1 for n in meshes])
    assert (errors > 1.5e-6).all()  # from above: Ritz
    order = np.log2(errors[:-1] / errors[1:])
    np.testing.assert_allclose(order, 4.0, atol=0.2)


def simply_supported_timoshenko(n, length, s):
    """The lower of the two frequencies of w = W sin(n pi z / L), slope = S cos(n pi z / L) [rad/s].

    Timoshenko's equations with these shapes: a 2 x 2 eigenvalue problem, in closed form.
    """
    p, GA, EI = n * np.pi / length, s.shear_stiffness, s.E * s.inertia
    # rho A rho I w^4 - (rho A (EI p^2 + GA) + rho I GA p^2) w^2 + GA p^2 EI p^2 = 0
    a = s.rho**2 * s.area * s.inertia
    b = s.rho * s.area * (EI * p**2 + GA) + s.rho * s.inertia * GA * p**2
    c = GA * EI * p**4
    return np.sqrt(2 * c / (b + np.sqrt(b**2 - 4 * a * c)))


@pytest.mark.parametrize("n", [1, 2, 3])
def test_a_thick_simply_supported_beam_tends_to_timoshenkos_frequency(n):
    # L/d = 4: shear and rotary inertia take 9, 26 and 39 %. Elements shorter than the beam is thick bend mostly by
    # shear, their shape functions become straight lines, and the order falls from 4 to 2.
    s = Section(0.25, 0.1)
    exact = simply_supported_timoshenko(n, 1.0, s)
    slender = (n * np.pi) ** 2 * np.sqrt(s.E * s.inertia / (s.rho * s.area))
    assert exact < 0.92 * slender
    errors = np.array([circular_frequencies(m * n, 1.0, s, True)[n - 1] / exact - 1 for m in (16, 32, 64)])
    np.testing.assert_allclose(np.log2(errors[:-1] / errors[1:]), 2.0, atol=0.05)
    assert 0 < errors[-1] < 1e-4


def test_nothing_locks_in_a_slender_beam():
    # one element and L/d = 1e5: with locking the stiffness would grow by (L/d)^2
    s = Section(1e-5)
    exact = np.pi**2 * np.sqrt(s.E * s.inertia / (s.rho * s.area))
    assert circular_frequencies(2, 1.0, s, True)[0] == pytest.approx(exact, rel=5e-3)
