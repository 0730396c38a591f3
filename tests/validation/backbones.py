#!/usr/bin/env python3
"""Backbones of thin bodies by Ritz's method, which share nothing with the programs.

    backbones.py plate AMPLITUDE...     a square plate, clamped, immovable edges, nu = 0.3
    backbones.py beam AMPLITUDE...      clamped at both ends, immovable
    backbones.py hinged AMPLITUDE...   hinged at one end, clamped at the other, immovable

Prints for each amplitude over the thickness (of the plate's middle, of the beam's largest place)
the frequency of the first free vibration over that of small vibration. --terms N: functions along
each axis, --harmonics N: odd harmonics.

Plate: von Karman's energy with in-plane displacements, without their inertia. Lengths in half a
side L, w in h, in-plane ones in h^2/L, time in L^2 sqrt(rho h/D):

    V = 1/2 int (lap w)^2 + 6 int (ex^2 + ey^2 + 2 nu ex ey + (1 - nu)/2 g^2),   T = 1/2 int w_t^2,

ex = u_x + w_x^2/2, g = u_y + v_x + w_x w_y. w: products of (1 - x^2)^2 P_2i, u: of (1 - x^2)
P_2i+1(x) P_2j(y), and v the same with x and y exchanged, so that w must be symmetric too. u follows
from w, which leaves an energy of fourth order in the coefficients of w.

Beam: V = 1/2 int w''^2 + 1/8 (12) (int w'^2)^2/L with lengths in L, w in h, time in
L^2 sqrt(rho A/EI); w: the modes of small vibration.

Both are solved by the balance of odd harmonics cos k omega t with Newton's method.
"""
import math
import sys


def solve(matrix, right):
    """x of matrix x = right by elimination with pivots; both are overwritten."""
    n = len(right)
    for i in range(n):
        p = max(range(i, n), key=lambda r: abs(matrix[r][i]))
        matrix[i], matrix[p] = matrix[p], matrix[i]
        right[i], right[p] = right[p], right[i]
        for r in range(i + 1, n):
            f = matrix[r][i] / matrix[i][i]
            if f:
                matrix[r] = [b - f * a for a, b in zip(matrix[i], matrix[r])]
                right[r] -= f * right[i]
    for i in reversed(range(n)):
        right[i] = (right[i] - sum(matrix[i][j] * right[j] for j in range(i + 1, n))) / matrix[i][i]
    return right


def gauss(n):
    """Points and weights of Gauss and Legendre on [-1, 1]."""
    points = []
    for i in range(n):
        x = math.cos(math.pi * (i + 0.75) / (n + 0.5))
        for _ in range(50):
            p, q = legendre(n, x)
            x -= p / q
        points.append((x, 2 / ((1 - x * x) * legendre(n, x)[1] ** 2)))
    return points


def legendre(n, x):
    """P_n and its derivative."""
    a, b = 1.0, x
    if n == 0:
        return 1.0, 0.0
    for k in range(1, n):
        a, b = b, ((2 * k + 1) * x * b - k * a) / (k + 1)
    return b, n * (x * b - a) / (x * x - 1)


def times(f, g):
    """Product of two functions as (value, first, second derivative)."""
    return (f[0] * g[0], f[1] * g[0] + f[0] * g[1], f[2] * g[0] + 2 * f[1] * g[1] + f[0] * g[2])


def legendre3(n, x):
    p, q = legendre(n, x)
    return (p, q, (2 * x * q - n * (n + 1) * p) / (1 - x * x))


class System:
    """a'' M + K a + dQ/da = 0, Q = sum quartic[ijkl] a_i a_j a_k a_l; shape: amplitude = shape . a."""

    def __init__(self, mass, stiffness, quartic, shape):
        self.mass, self.stiffness, self.shape = mass, stiffness, shape
        self.n = len(shape)
        # The gradient's coefficients: 4 q of the symmetric tensor, packed by its last three.
        self.quartic = quartic

    def force(self, a):
        n = self.n
        pairs = [[a[k] * a[l] for l in range(n)] for k in range(n)]
        out = []
        for i in range(n):
            total = 0.0
            for j in range(n):
                if a[j]:
                    row = self.quartic[i][j]
                    total += a[j] * sum(row[k][l] * pairs[k][l] for k in range(n) for l in range(n))
            out.append(4 * total)
        return out

    def lowest(self):
        """Frequency and shape of the lowest mode by inverse iteration, with amplitude one."""
        a = [1.0] + [0.0] * (self.n - 1)
        for _ in range(60):
            right = [sum(m * x for m, x in zip(row, a)) for row in self.mass]
            a = solve([row[:] for row in self.stiffness], right)
            size = math.sqrt(sum(x * x for x in a))
            a = [x / size for x in a]
        top = sum(x * sum(k * y for k, y in zip(row, a)) for x, row in zip(a, self.stiffness))
        down = sum(x * sum(m * y for m, y in zip(row, a)) for x, row in zip(a, self.mass))
        scale = sum(s * x for s, x in zip(self.shape, a))
        return math.sqrt(top / down), [x / scale for x in a]

    def balance(self, y, amplitude, harmonics):
        """Residual of the unknowns y: coefficients of cos (2k + 1) omega t, then omega."""
        n = self.n
        parts = [y[k * n:(k + 1) * n] for k in range(harmonics)]
        omega = y[-1]
        # A quarter of a period is enough; the force has harmonics up to three times as high.
        samples = 2 * harmonics + 1
        force = [[0.0] * n for _ in range(harmonics)]
        for s in range(samples):
            theta = math.pi * (s + 0.5) / (2 * samples)
            cosines = [math.cos((2 * k + 1) * theta) for k in range(harmonics)]
            a = [sum(c * part[i] for c, part in zip(cosines, parts)) for i in range(n)]
            f = self.force(a)
            for k in range(harmonics):
                for i in range(n):
                    force[k][i] += 2 * f[i] * cosines[k] / samples
        out = []
        for k, part in enumerate(parts):
            speed = ((2 * k + 1) * omega) ** 2
            for i in range(n):
                out.append(force[k][i] + sum((self.stiffness[i][j] - speed * self.mass[i][j]) * part[j]
                                             for j in range(n)))
        out.append(sum(s * sum(part[i] for part in parts) for i, s in enumerate(self.shape)) - amplitude)
        return out

    def backbone(self, amplitudes, harmonics):
        """omega over the linear one at each amplitude, which must ascend."""
        linear, mode = self.lowest()
        y = [0.0] * (self.n * harmonics) + [linear]
        before, ratios = 0.0, []
        for amplitude in amplitudes:
            for part in range(1, 5):
                at = before + (amplitude - before) * part / 4
                last = sum(s * sum(y[k * self.n + i] for k in range(harmonics))
                           for i, s in enumerate(self.shape))
                for i in range(self.n):
                    y[i] = y[i] * at / last if last else mode[i] * at
                for _ in range(12):
                    base = self.balance(y, at, harmonics)
                    columns = []
                    for j in range(len(y)):
                        e = 1e-6 * (1 if j == len(y) - 1 else at)
                        moved = y[:]
                        moved[j] += e
                        columns.append([(m - b) / e for m, b in zip(self.balance(moved, at, harmonics), base)])
                    step = solve([list(row) for row in zip(*columns)], [-b for b in base])
                    y = [a + b for a, b in zip(y, step)]
                    if max(abs(s) for s in step) < 1e-9:
                        break
                else:
                    raise SystemExit("backbones.py: Newton's method does not converge")
            before = amplitude
            ratios.append(y[-1] / linear)
        return ratios


def plate(terms, nu=0.3):
    points = gauss(2 * terms + 12)
    m = terms + 4  # in-plane functions along each axis
    clamped = [[times((1 - x * x, -2 * x, -2.0), times((1 - x * x, -2 * x, -2.0), legendre3(2 * i, x)))
                for i in range(terms)] for x, _ in points]
    odd = [[times((1 - x * x, -2 * x, -2.0), legendre3(2 * i + 1, x)) for i in range(m)] for x, _ in points]
    even = [[times((1 - x * x, -2 * x, -2.0), legendre3(2 * i, x)) for i in range(m)] for x, _ in points]
    pairs = [(i, j) for i in range(terms) for j in range(i + 1)]
    plane = [(i, j) for i in range(m) for j in range(m)]
    n, count = len(pairs), len(plane)
    mass = [[0.0] * n for _ in range(n)]
    stiffness = [[0.0] * n for _ in range(n)]
    inplane = [[0.0] * count for _ in range(count)]
    two = [(i, j) for i in range(n) for j in range(i + 1)]  # products of two coefficients of w
    load = [[0.0] * count for _ in two]
    direct = [[0.0] * len(two) for _ in two]
    for a, (_, wa) in enumerate(points):
        for b, (_, wb) in enumerate(points):
            weight = wa * wb
            f, g = clamped[a], clamped[b]
            value = [f[i][0] * g[j][0] + f[j][0] * g[i][0] for i, j in pairs]
            dx = [f[i][1] * g[j][0] + f[j][1] * g[i][0] for i, j in pairs]
            dy = [f[i][0] * g[j][1] + f[j][0] * g[i][1] for i, j in pairs]
            lap = [f[i][2] * g[j][0] + f[j][2] * g[i][0] + f[i][0] * g[j][2] + f[j][0] * g[i][2]
                   for i, j in pairs]
            for i in range(n):
                for j in range(n):
                    mass[i][j] += weight * value[i] * value[j]
                    stiffness[i][j] += weight * lap[i] * lap[j]
            # Strains of the in-plane functions, (ex, ey, g), and stresses 12 C e.
            strain = [(odd[a][i][1] * even[b][j][0], even[a][j][0] * odd[b][i][1],
                       odd[a][i][0] * even[b][j][1] + even[a][j][1] * odd[b][i][0]) for i, j in plane]
            stress = [(12 * (e[0] + nu * e[1]), 12 * (e[1] + nu * e[0]), 6 * (1 - nu) * e[2])
                      for e in strain]
            for i in range(count):
                s = [weight * c for c in stress[i]]
                row = inplane[i]
                for j in range(count):
                    e = strain[j]
                    row[j] += s[0] * e[0] + s[1] * e[1] + s[2] * e[2]
            # Strains of the products of two coefficients: once for i = j, twice else.
            bent = []
            for i, j in two:
                factor = 0.5 if i == j else 1.0
                bent.append((factor * dx[i] * dx[j], factor * dy[i] * dy[j],
                             factor * (dx[i] * dy[j] + dx[j] * dy[i])))
            for p, e in enumerate(bent):
                row = load[p]
                for i in range(count):
                    s = stress[i]
                    row[i] += weight * (s[0] * e[0] + s[1] * e[1] + s[2] * e[2])
                s = (12 * weight * (e[0] + nu * e[1]), 12 * weight * (e[1] + nu * e[0]),
                     6 * (1 - nu) * weight * e[2])
                row = direct[p]
                for q, d in enumerate(bent):
                    row[q] += s[0] * d[0] + s[1] * d[1] + s[2] * d[2]
    answers = [solve([row[:] for row in inplane], load[p][:]) for p in range(len(two))]
    quartic = [[[[0.0] * n for _ in range(n)] for _ in range(n)] for _ in range(n)]
    for p, (i, j) in enumerate(two):
        for q, (k, l) in enumerate(two):
            c = 0.5 * (direct[p][q] - sum(x * y for x, y in zip(answers[p], load[q])))
            spread = {(s, t, u, v) for s, t in ((i, j), (j, i)) for u, v in ((k, l), (l, k))}
            spread |= {(u, v, s, t) for s, t, u, v in spread}
            for s, t, u, v in spread:
                quartic[s][t][u][v] += c / len(spread)
    centre = [2 * legendre(2 * i, 0.0)[0] * legendre(2 * j, 0.0)[0] for i, j in pairs]
    return System(mass, stiffness, symmetric(quartic), centre)


def symmetric(q):
    """The mean over all orders of the four indices."""
    n = len(q)
    out = [[[[0.0] * n for _ in range(n)] for _ in range(n)] for _ in range(n)]
    for i in range(n):
        for j in range(n):
            for k in range(n):
                for l in range(n):
                    out[i][j][k][l] = (q[i][j][k][l] + q[i][k][j][l] + q[i][l][k][j] +
                                       q[k][j][i][l] + q[l][j][k][i] + q[k][l][i][j]) / 6
    return out


def beam(terms, hinged):
    """Modes by the zeros of tan b = tanh b (hinged and clamped), or of cos b cosh b = 1, even ones."""
    roots = []
    for i in range(terms):
        if hinged:
            b = (i + 1.25) * math.pi
            for _ in range(60):
                b = (i + 1) * math.pi + math.atan(math.tanh(b))
        else:
            b = (2 * i + 1.5) * math.pi
            for _ in range(60):  # half of it solves tan c = -tanh c
                b = 2 * ((i + 1) * math.pi - math.atan(math.tanh(b / 2)))
        roots.append(b)

    def mode(b, x):
        """Value and slope; x from the hinge, or from the middle, in L."""
        if hinged:
            k = math.sin(b) / math.sinh(b)
            return math.sin(b * x) - k * math.sinh(b * x), b * (math.cos(b * x) - k * math.cosh(b * x))
        k = math.cos(b / 2) / math.cosh(b / 2)
        return math.cos(b * x) - k * math.cosh(b * x), -b * (math.sin(b * x) + k * math.sinh(b * x))

    low, high = (0.0, 1.0) if hinged else (-0.5, 0.5)
    points = [(low + 0.5 * (x + 1) * (high - low), 0.5 * (high - low) * w) for x, w in gauss(60)]
    table = [[mode(b, x) for b in roots] for x, _ in points]
    n = terms
    mass = [[sum(w * t[i][0] * t[j][0] for (_, w), t in zip(points, table)) for j in range(n)] for i in range(n)]
    slopes = [[sum(w * t[i][1] * t[j][1] for (_, w), t in zip(points, table)) for j in range(n)] for i in range(n)]
    stiffness = [[roots[i] ** 4 * mass[i][i] if i == j else 0.0 for j in range(n)] for i in range(n)]
    quartic = [[[[1.5 * slopes[i][j] * slopes[k][l] for l in range(n)] for k in range(n)] for j in range(n)]
               for i in range(n)]
    # The place that moves most in the first mode.
    best = max((0.001 * i for i in range(1001)), key=lambda s: abs(mode(roots[0], low + s * (high - low))[0]))
    return System(mass, stiffness, symmetric(quartic), [mode(b, low + best * (high - low))[0] for b in roots])


def main(words):
    terms, harmonics, amplitudes = None, 3, []
    words = words[:]
    body = words.pop(0) if words else ""
    while words:
        word = words.pop(0)
        if word == "--terms":
            terms = int(words.pop(0))
        elif word == "--harmonics":
            harmonics = int(words.pop(0))
        else:
            amplitudes.append(float(word))
    if body not in ("plate", "beam", "hinged") or not amplitudes:
        raise SystemExit(__doc__)
    system = plate(terms or 3) if body == "plate" else beam(terms or 3, body == "hinged")
    for amplitude, ratio in zip(amplitudes, system.backbone(amplitudes, harmonics)):
        print(f"{amplitude:g} {ratio:.6f}")


if __name__ == "__main__":
    main(sys.argv[1:])
