"""Complex modes as those of a real system: mass, damping and stiffness from shapes and poles.

Modes psi_r of a real system, scaled so that psi_r psi_r' is the residue of H at the pole, obey sum psi psi' = 0 with
their conjugates included: at very high frequency only masses move, H falls with the square of the frequency.
Shapes from data do so only nearly. (Balmes 1997, Mechanical Systems and Signal Processing 11, 229-243.)
"""

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

# Rounds of the search for the nearest shapes that a real system can have, and what may be left then.
ROUNDS, LEFT = 50, 1e-10


def real_matrices(Phi: Complex, omega: Array, zeta: Array) -> tuple[Array, Array, Array]:
    """M, C and K of the real system whose complex modes are nearest to Phi, with these poles.

    Parameters
    ----------
    Phi : (n, n) complex [1/sqrt(kg)]
        Shapes; phi / sqrt(2 i omega_d) is psi.
    omega : (n,) [rad/s]
    zeta : (n,) [-]

    Raises
    ------
    ValueError
        When a mode does not oscillate, or the shapes are so complex that none of a real system are near.
    """
    if (zeta >= 1).any():
        raise ValueError(f"zeta holds {zeta.max():g}: a complex shape belongs to a mode that oscillates, zeta < 1.")
    omega_d = omega * np.sqrt(1 - zeta**2)
    poles = -zeta * omega + 1j * omega_d
    psi = proper(Phi / np.sqrt(2j * omega_d))
    inverse_mass, inverse_stiffness, rate = (
        2 * np.real(psi * power @ psi.T) for power in (poles, -1 / poles, poles**2)
    )
    M, K = linalg.inv(inverse_mass), linalg.inv(inverse_stiffness)
    M, K, C = (A / 2 + A.T / 2 for A in (M, K, -M @ rate @ M))
    return M, C, K


def proper(psi: Complex) -> Complex:
    """The nearest shapes (least squares) with Re psi psi' = 0: (1 - d^2)^-1 (psi - d conj(psi)) with d symmetric.

    The multipliers d follow from S - d P - P d + d S d = 0 with S = Re psi psi' and P = Re psi psi*: a Lyapunov
    equation with a small correction, as S is small for shapes that are nearly real.
    """
    S, P = np.real(psi @ psi.T), np.real(psi @ psi.conj().T)
    d = np.zeros_like(S)
    for _ in range(ROUNDS):
        d = linalg.solve_continuous_lyapunov(P, S + d @ S @ d)
    nearest = linalg.solve(np.eye(len(d)) - d @ d, psi - d @ psi.conj())
    left = np.abs(np.real(nearest @ nearest.T)).max() / np.abs(P).max()
    if not left < LEFT:
        raise ValueError(
            f"Phi is too complex for the modes of a real system: with {ROUNDS} rounds of correction {left:.1e} of it "
            "is left over. Keep the real parts, or look at the phases of its columns."
        )
    return np.asarray(nearest)
