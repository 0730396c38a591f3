# Closed forms that the solids are compared with; nu = 0 where it would matter.

function tanh(u) { return 1 - 2 / (exp(2 * u) + 1) }
function sinh(u) { return (exp(u) - exp(-u)) / 2 }
function cosh(u) { return (exp(u) + exp(-u)) / 2 }
function asin(s) { return atan2(s, sqrt(1 - s * s)) }

# Incomplete elliptic integrals of modulus p, first and second kind, by Simpson's rule.
function elliptic(kind, p, angle,    n, k, s, f, sum) {
  n = 400
  for (k = 0; k <= n; k++) {
    s = sqrt(1 - (p * sin(angle * k / n)) ^ 2)
    f = kind == 1 ? 1 / s : s
    sum += f * (k == 0 || k == n ? 1 : k % 2 ? 4 : 2)
  }
  return sum * angle / (3 * n)
}

# Cantilever under a load P across its end that keeps its direction, not extensible: the slope of the
# end for load = P L^2 / EI, then tip[1] = u/L (drawn in) and tip[2] = w/L (deflected).
# Bisshopp & Drucker, Quarterly of Applied Mathematics 3 (1945) 272-275.
function elastica(load, tip,    pi, low, high, slope, p, start, i) {
  pi = atan2(0, -1)
  low = 0
  high = pi / 2
  for (i = 0; i < 60; i++) {
    slope = (low + high) / 2
    p = sqrt((1 + sin(slope)) / 2)
    start = asin(1 / (p * sqrt(2)))
    if ((elliptic(1, p, pi / 2) - elliptic(1, p, start)) ^ 2 < load) low = slope
    else high = slope
  }
  tip[1] = 1 - sqrt(2 * sin(slope) / load)
  tip[2] = 1 - 2 / sqrt(load) * (elliptic(2, p, pi / 2) - elliptic(2, p, start))
  return slope
}
function elastica_u(load,    tip) { elastica(load, tip); return tip[1] }
function elastica_w(load,    tip) { elastica(load, tip); return tip[2] }

# Long plate or strip with built-in edges under a uniform load: w/h in the middle for
# load = q l^4 / (E h^4), q the pressure. nu = 0.
# Timoshenko & Woinowsky-Krieger, Theory of Plates and Shells, 2nd ed. (1959), section 3.
function built_in_strip(load,    low, high, u, i, deflection) {
  low = 0.05
  high = 40
  for (i = 0; i < 80; i++) {
    u = (low + high) / 2
    # U_1(u) = (E h^4 / (q l^4))^2 falls with u.
    if (strip_tension(u) * load ^ 2 > 1) low = u
    else high = u
  }
  # w = q l^4 / (384 D) f_1(u), D = E h^3 / 12.
  deflection = 24 / u ^ 4 * (u ^ 2 / 2 + u / sinh(u) - u / tanh(u))
  return load / 32 * deflection
}
function strip_tension(u) {
  return -81 / (16 * u ^ 7 * tanh(u)) - 27 / (16 * u ^ 6 * sinh(u) ^ 2) + \
         27 / (4 * u ^ 8) + 9 / (8 * u ^ 6)
}

# Timoshenko's beam, clamped at one end and at the other free (ends = 1) or clamped (2), thickness
# over length `slender`, rectangular, shear factor 5/6: omega over the sqrt(EI / (rho A L^4)) of
# Euler-Bernoulli, the root next to that beam's own, `guess`.
# Timoshenko, Philosophical Magazine 41 (1921) 744-746.
function timoshenko(ends, slender, guess,    low, high, middle, i, sign) {
  low = 0.9 * guess
  high = 1.01 * guess
  sign = end_determinant(ends, slender, low)
  for (i = 0; i < 40; i++) {
    middle = (low + high) / 2
    if (end_determinant(ends, slender, middle) * sign > 0) low = middle
    else high = middle
  }
  return middle
}

# Of what must vanish at the far end, after shooting from the clamped one with moment 1 and with
# shear force 1.
function end_determinant(ends, slender, omega,    a, b, first, second) {
  shoot(slender, omega, 1, 0, a)
  shoot(slender, omega, 0, 1, b)
  first = ends == 1 ? 2 : 0
  return a[first] * b[first + 1] - b[first] * a[first + 1]
}

# y = (w, slope, moment, shear) over a length 1 with EI = rho A = 1, from (0, 0, moment, shear):
# w' = slope + g V, slope' = M, M' = -V - omega^2 r^2 slope, V' = -omega^2 w, by Runge and Kutta.
function shoot(slender, omega, moment, shear, y,    n, i, c, k, s, f, z, r2, total, weight) {
  r2 = slender ^ 2 / 12
  n = 400
  y[0] = y[1] = 0
  y[2] = moment
  y[3] = shear
  for (i = 0; i < n; i++) {
    for (c = 0; c < 4; c++) total[c] = f[c] = 0
    for (k = 0; k < 4; k++) {
      s = k == 0 ? 0 : k == 3 ? 1 : 0.5
      weight = k == 0 || k == 3 ? 1 : 2
      for (c = 0; c < 4; c++) z[c] = y[c] + s / n * f[c]
      f[0] = z[1] + 2.4 * r2 * z[3]
      f[1] = z[2]
      f[2] = -z[3] - omega ^ 2 * r2 * z[1]
      f[3] = -omega ^ 2 * z[0]
      for (c = 0; c < 4; c++) total[c] += weight * f[c]
    }
    for (c = 0; c < 4; c++) y[c] += total[c] / (6 * n)
  }
}
