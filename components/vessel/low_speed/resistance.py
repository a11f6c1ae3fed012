"""What water resists a hull's velocity with: linear, quadratic and cubic damping, and cross-flow drag by strips."""

from components.compiled import kernel
from components.vessel.yawing import FREE, R, U, V

# Linear: forces [N, N m] per velocity; then by products: X per |u|u and u^3, Y and N per |v|v, |r|v, |v|r, |r|r.
X_U, Y_V, Y_R, N_V, N_R = range(5)
X_UU, X_UUU, Y_VV, Y_RV, Y_VR, Y_RR, N_VV, N_RV, N_VR, N_RR = range(5, 15)
COEFFICIENTS = 15


@kernel
def resist_velocity(d, m, f, g):
    """Add the damping D nu + D_n(|nu|) nu to the balance f and its slope to g; d: (15) positive where it resists.

    Fossen 2011, eq. 7.75, in the form of Skjetne et al. 2004 (MIC 25, eqs. 8 to 10).
    """
    u, v, r = m[U], m[V], m[R]
    au, av, ar = abs(u), abs(v), abs(r)
    sv, sr = 1.0 if v > 0.0 else -1.0, 1.0 if r > 0.0 else -1.0
    f[0] += (d[X_U] + d[X_UU] * au + d[X_UUU] * u * u) * u
    g[0] += d[X_U] + 2.0 * d[X_UU] * au + 3.0 * d[X_UUU] * u * u
    for k in range(2):
        row, linear, first = (1, Y_V, Y_VV) if k == 0 else (3, N_V, N_VV)
        vv, rv, vr, rr = d[first], d[first + 1], d[first + 2], d[first + 3]
        f[row] += (d[linear] + vv * av + rv * ar) * v + (d[linear + 1] + vr * av + rr * ar) * r
        g[FREE * row + 1] += d[linear] + 2.0 * vv * av + rv * ar + vr * sv * r
        g[FREE * row + 3] += d[linear + 1] + 2.0 * rr * ar + vr * av + rv * sr * v


@kernel
def resist_cross_flow(strips, count, m, f, g):
    """Add the drag of a hull across the flow, strip by strip; strips: x [m], rho C_D T dx / 2 [kg/m], count times.

    Faltinsen 1990, eq. 6.6; Fossen 2011, eqs. 7.89 and 7.90: each strip meets the flow v + x r.
    """
    v, r = m[V], m[R]
    for i in range(count):
        x, k = strips[2 * i], strips[2 * i + 1]
        flow = v + x * r
        drag, steep = k * abs(flow) * flow, 2.0 * k * abs(flow)
        f[1] += drag
        f[3] += x * drag
        g[FREE + 1] += steep
        g[FREE + 3] += steep * x
        g[3 * FREE + 1] += steep * x
        g[3 * FREE + 3] += steep * x * x
