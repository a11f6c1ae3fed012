"""Motion of a hull in an irregular sea by its transfer functions, and the waves' drift force on it.

A sea is n components: amplitude a [m], frequency omega [rad/s], wave number k [rad/m], direction beta that it runs to
(clockwise from north) and phase; its surface is the sum of a cos(theta), theta = k x - omega t + phase, x along beta.
Motions are the sum of Re(a H(omega, beta - psi) exp(i theta)), H being the complex transfer function of the table.
"""

from math import cos, floor, pi, sin

from components.compiled import kernel

# Of a table's cell: real and imaginary part of surge, sway, heave [m/m], roll, pitch, yaw [rad/m], then the mean drift
# force over the amplitude squared: surge, sway [N/m^2], yaw [N/m].
MODES = 6
CELL = 15
# A moved hull: its six motions, their first and second rates, and the drift force (3).
RESPONSE = 21


@kernel
def between(table, n, value):
    """Which of the n ascending numbers of the table is the last below the value, and the fraction to the next."""
    if value <= table[0]:
        return 0, 0.0
    if value >= table[n - 1]:
        return n - 2, 1.0
    low, high = 0, n - 1
    while high - low > 1:
        middle = (low + high) // 2
        if table[middle] <= value:
            low = middle
        else:
            high = middle
    return low, (value - table[low]) / (table[low + 1] - table[low])


@kernel
def look_up(table, omega, chi, cell):
    """Set cell (15) to the table's at a frequency and a direction chi relative to the bow, linear in both.

    table: numbers of frequencies and of directions, which go evenly from 0 (from astern) to 180 deg; the frequencies;
    then a cell for each direction and frequency. A hull is alike on both sides: sway, roll, yaw and their drift change
    sign with chi.
    """
    n, directions = int(table[0]), int(table[1])
    chi -= 2.0 * pi * floor(chi / (2.0 * pi) + 0.5)
    side = 1.0 if chi >= 0.0 else -1.0
    i, f = between(table[2 : 2 + n], n, omega)
    place = abs(chi) / pi * (directions - 1)
    j = min(int(place), directions - 2)
    d = place - j
    first = 2 + n
    a, b = first + CELL * (j * n + i), first + CELL * ((j + 1) * n + i)
    for k in range(CELL):
        near = table[a + k] + f * (table[a + CELL + k] - table[a + k])
        far = table[b + k] + f * (table[b + CELL + k] - table[b + k])
        cell[k] = near + d * (far - near)
    for k in (2, 3, 6, 7, 10, 11, 13, 14):
        cell[k] *= side


@kernel
def respond(table, sea, n, eta, rate, t, cell, z):
    """Set z (21) to the motions, their rates, and the drift force of the n components at t [s].

    sea: amplitudes (n), frequencies (n), wave numbers (n), directions (n), phases (n). The drift is Newman's (1974):
    a pair of components pulls by the mean of their own drift coefficients, which makes the double sum the product of
    two single ones and leaves only differences of frequencies in it.
    """
    for k in range(RESPONSE):
        z[k] = 0.0
    whole_c = whole_s = 0.0
    x_c = x_s = y_c = y_s = n_c = n_s = 0.0
    for i in range(n):
        a, omega, number, beta = sea[i], sea[n + i], sea[2 * n + i], sea[3 * n + i]
        cn, ce = cos(beta), sin(beta)
        theta = number * (cn * eta[0] + ce * eta[1]) - omega * t + sea[4 * n + i]
        pace = number * (cn * rate[0] + ce * rate[1]) - omega
        look_up(table, omega, beta - eta[3], cell)
        c, s = a * cos(theta), a * sin(theta)
        for k in range(MODES):
            h, g = cell[2 * k], cell[2 * k + 1]
            motion = h * c - g * s
            z[k] += motion
            z[MODES + k] -= pace * (h * s + g * c)
            z[2 * MODES + k] -= pace * pace * motion
        whole_c, whole_s = whole_c + c, whole_s + s
        x_c, x_s = x_c + cell[12] * c, x_s + cell[12] * s
        y_c, y_s = y_c + cell[13] * c, y_s + cell[13] * s
        n_c, n_s = n_c + cell[14] * c, n_s + cell[14] * s
    z[18] = x_c * whole_c + x_s * whole_s
    z[19] = y_c * whole_c + y_s * whole_s
    z[20] = n_c * whole_c + n_s * whole_s


@kernel
def offset(r, z, s):
    """Set s (9) to where a point at r of the hull at rest is and moves in the body frame, for small angles."""
    for d in range(3):
        k = 6 * d
        roll, pitch, yaw = z[k + 3], z[k + 4], z[k + 5]
        s[3 * d] = z[k] + pitch * r[2] - yaw * r[1]
        s[3 * d + 1] = z[k + 1] + yaw * r[0] - roll * r[2]
        s[3 * d + 2] = z[k + 2] + roll * r[1] - pitch * r[0]
    for i in range(3):
        s[i] += r[i]
