"""Binds the mass to the contract."""

from components.compiled import kernel
from components.contract import HEADER, BodyEnd, Component
from components.vessel.mass import model
from components.vessel.mass.translation import predict, reach, solve

MASS = HEADER
WEIGHT, STIFFNESS, DAMPING, REST, START = range(HEADER + 1, HEADER + 16, 3)
TAKES_FORCE, TAKES_LAW = range(HEADER + 22, HEADER + 24)
Q, V, ACC, A = range(0, 12, 3)
FORCE, MATRIX = 0, 3  # in w: (3), and xx, yy, zz, xy, xz, yz


@kernel
def effective_mass(p, i, h):
    """What a force along the axis i works against over h [s], -d balance / d acc [kg]."""
    q_acc, v_acc = reach(h)
    return p[MASS] + v_acc * p[DAMPING + i] + q_acc * p[STIFFNESS + i]


@kernel
def observe(p, x, h, y):
    """Write the hook's motion and, with a law, its accelerance."""
    for i in range(9):
        y[i] = x[i]
    if p[TAKES_LAW] > 0.0:
        for i in range(9, 18):
            y[i] = 0.0
        for i in range(3):
            y[9 + 4 * i] = 1.0 / effective_mass(p, i, h)


@kernel
def add_law(u, k, w):
    """Add the line's law at u[k:], force - mass (acc - acceleration), to the balance in w."""
    g = k + 6
    for i in range(3):
        w[FORCE + i] += u[k + i]
        for j in range(3):
            w[FORCE + i] += u[g + 3 * i + j] * u[k + 3 + j]
        w[MATRIX + i] += u[g + 4 * i]
    w[MATRIX + 3] += u[g + 1]
    w[MATRIX + 4] += u[g + 2]
    w[MATRIX + 5] += u[g + 5]


def init(t_ns, dt_ns, p, u, x, y, w):
    """Start as the parameters say."""
    for i in range(9):
        x[i] = p[START + i]
    for i in range(3):
        x[A + i] = x[ACC + i]
    observe(p, x, dt_ns * 1e-9, y)
    return 0


def step(t_ns, dt_ns, p, u, x, y, w):
    """Solve the balance at the step's end, M acc + C v + K (q - rest) = weight + force + law(acc), for acc."""
    h = dt_ns * 1e-9
    law = 3 if p[TAKES_FORCE] > 0.0 else 0
    q_acc, v_acc = reach(h)
    for i in range(3):
        q, v = predict(x[Q + i], x[V + i], x[A + i], h)
        x[Q + i], x[V + i] = q, v
        w[FORCE + i] = p[WEIGHT + i] - p[STIFFNESS + i] * (q - p[REST + i]) - p[DAMPING + i] * v
        w[MATRIX + i] = effective_mass(p, i, h)
        w[MATRIX + 3 + i] = 0.0
        if law == 3:
            w[FORCE + i] += u[i]
    if p[TAKES_LAW] > 0.0:
        add_law(u, law, w)
    x[ACC], x[ACC + 1], x[ACC + 2] = solve(w[3], w[4], w[5], w[6], w[7], w[8], w[0], w[1], w[2])
    for i in range(3):
        x[Q + i] += q_acc * x[ACC + i]
        x[V + i] += v_acc * x[ACC + i]
        x[A + i] = 0.5 * (x[ACC + i] + x[A + i])
    observe(p, x, h, y)
    return 0


COMPONENT = Component(
    name="vessel.mass",
    parameters=model.Mass,
    inputs=model.inputs,
    outputs=model.outputs,
    sizes=model.sizes,
    init=init,
    step=step,
    terms=model.terms,
    bodies={"hook": BodyEnd(motion="hook", law="line", switch="takes_law", accelerance="accelerance")},
    assumptions="No rotation; linear springs and dampers; the hook is the centre of mass.",
)
