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

    theta: (n) angles clockwise from north [rad]; segment: length [m]; normal, tangential: c_S, c_V [N s/m^2].
    """
    n = len(theta)
    for i in range(n):
        for j in range(n):
            drag[i, j] = 0.0
        for j in range(4):
            sides[i, j] = 0.0
    for i in range(n):
        c, s = cos(theta[i]), sin(theta[i])
        # Drag per velocity of the segment's middle, along north and east.
        nn = segment * (tangential * c * c + normal * s * s)
        ne = segment * (tangential - normal) * c * s
        ee = segment * (tangential * s * s + normal * c * c)
        drag[i, i] += normal * segment * segment * segment / 12.0
        for j in range(i + 1):
            arm = segment if j < i else 0.5 * segment
            jn, je = -arm * sin(theta[j]), arm * cos(theta[j])
            fn, fe = nn * jn + ne * je, ne * jn + ee * je
            sides[j, 0] += fn
            sides[j, 1] += fe
            for k in range(j + 1):
                arm = segment if k < i else 0.5 * segment
                term = arm * (fe * cos(theta[k]) - fn * sin(theta[k]))
                drag[j, k] += term
                if j != k:
                    drag[k, j] += term
        sides[i, 2], sides[i, 3] = -segment * s, segment * c


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
        s, c = -segment * sin(theta[i]), segment * cos(theta[i])
        xx += s * sides[i, 2]
        xy += s * sides[i, 3]
        yy += c * sides[i, 3]
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
