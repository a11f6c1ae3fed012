"""How fast the segments of a towed line turn when its ends move: Bhattacharya et al. 2011, eqs. 20, 22 and 24.

Without inertia the line moves so that the drag's dissipation D = 1/2 int (c_V v_t^2 + c_S v_n^2) ds is least for the
given velocities of the ends: C theta' + H P_L' = G' f, G theta' = P_R' - P_L', with f the pull of the right end. In
the paper's form (23) that is A P' + B theta' = 0 with B = I, A = -S, theta' = S P'. (Their rows could be combined in
any way, which makes A^+ B of (25) depend on it for more than four segments; with B = I what is least is the miss in the
segments' rates themselves.)
"""

from math import cos, sin, sqrt

from components.compiled import kernel

THIN = 1e-9  # of its trace: below this the pull along a straight line is taken as undetermined


@kernel
def mobility(theta, segment, normal, tangential, drag, sides):
    """Write the drag matrix C (n, n) and H (n, 2) in the first two columns of sides (n, 4), G' in the other two.

    theta: (n) angles clockwise from north [rad]; segment: length [m]; normal, tangential: c_S, c_V [N s/m^2]. A segment
    drags along what is before it: from the last on, nn, ne and ee sum the drag per velocity of those behind it.
    """
    n = len(theta)
    nn = ne = ee = 0.0
    for i in range(n):
        sides[i, 2], sides[i, 3] = -segment * sin(theta[i]), segment * cos(theta[i])
    for j in range(n - 1, -1, -1):
        jn, je = sides[j, 2], sides[j, 3]
        c, s = je / segment, -jn / segment
        own_nn = segment * (tangential * c * c + normal * s * s)
        own_ne = segment * (tangential - normal) * c * s
        own_ee = segment * (tangential * s * s + normal * c * c)
        # Of the segment's turning, on what is behind and on half of its own length.
        fn = (nn + 0.5 * own_nn) * jn + (ne + 0.5 * own_ne) * je
        fe = (ne + 0.5 * own_ne) * jn + (ee + 0.5 * own_ee) * je
        sides[j, 0], sides[j, 1] = fn, fe
        drag[j, j] = (nn * jn + ne * je) * jn + (ne * jn + ee * je) * je + normal * segment * segment * segment / 3.0
        for k in range(j):
            drag[j, k] = drag[k, j] = fn * sides[k, 2] + fe * sides[k, 3]
        nn += own_nn
        ne += own_ne
        ee += own_ee


@kernel
def factor(m):
    """Replace a symmetric positive matrix by its Cholesky factor, in the lower triangle."""
    for j in range(m.shape[0]):
        for k in range(j):
            m[j, j] -= m[j, k] * m[j, k]
        m[j, j] = sqrt(m[j, j])
        for i in range(j + 1, m.shape[0]):
            for k in range(j):
                m[i, j] -= m[i, k] * m[j, k]
            m[i, j] /= m[j, j]


@kernel
def solve(m, b):
    """Solve with the factor for each column of b (n, k), in place."""
    n = m.shape[0]
    for c in range(b.shape[1]):
        for i in range(n):
            for k in range(i):
                b[i, c] -= m[i, k] * b[k, c]
            b[i, c] /= m[i, i]
        for i in range(n - 1, -1, -1):
            for k in range(i + 1, n):
                b[i, c] -= m[k, i] * b[k, c]
            b[i, c] /= m[i, i]


@kernel
def turning(theta, segment, normal, tangential, drag, sides, rates):
    """Write S (n, 4), the segments' rates per velocity of the left and the right end, north and east of each [rad/m].

    A straight line cannot be stretched: there its pull is undetermined, and the part of a velocity that would do it
    turns nothing.
    """
    n = len(theta)
    mobility(theta, segment, normal, tangential, drag, sides)
    factor(drag)
    solve(drag, sides)  # C^-1 H, C^-1 G'
    xx = xy = yy = 0.0
    for i in range(n):
        north, east = -segment * sin(theta[i]), segment * cos(theta[i])
        xx += north * sides[i, 2]
        xy += north * sides[i, 3]
        yy += east * sides[i, 3]
    floor = THIN * (xx + yy)
    xx += floor
    yy += floor
    determinant = xx * yy - xy * xy
    # Columns: pulls (2) for a unit velocity of each end, of the left one with what it drags along.
    for j in range(4):
        north = east = 0.0
        if j < 2:
            for i in range(n):
                north -= segment * sin(theta[i]) * sides[i, j]
                east += segment * cos(theta[i]) * sides[i, j]
        sign = -1.0 if j < 2 else 1.0
        north += sign if j % 2 == 0 else 0.0
        east += sign if j % 2 == 1 else 0.0
        fn, fe = (yy * north - xy * east) / determinant, (xx * east - xy * north) / determinant
        for i in range(n):
            rates[i, j] = sides[i, 2] * fn + sides[i, 3] * fe - (sides[i, j] if j < 2 else 0.0)
