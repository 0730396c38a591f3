# A synthetic record of an earthquake: accelerations of the ground, m/s^2, as CSV.
#
#     awk -f assets/recipes/earthquake.awk > assets/scenes/earthquake.csv
#
# Of each direction: normal white noise every 5 ms (Park and Miller's generator, seeds below), through the
# ground (Kanai and Tajimi: an oscillator of 2.2 Hz with 0.5 of critical damping, which passes on its absolute
# acceleration) and through a high pass of 0.35 Hz and 0.7 (Clough and Penzien); times an envelope that grows
# as t^2 up to 2 s, stays up to 7 s and falls as exp(-0.6 (t - 7)); every fourth value is kept. The baseline is
# corrected by two smooth functions, sin^2(pi t/T) and t/T times that, so that the straight lines between the
# values leave the ground at rest and where it was. The largest value is 2.5 m/s^2 along x and y, 1.2 along z.
function uniform() { seed = (16807 * seed) % 2147483647; return seed / 2147483647 }
function normal() { return sqrt(-2 * log(uniform())) * cos(2 * pi * uniform()) }

function envelope(t) {
  if (t < 2) return t * t / 4
  return t < 7 ? 1 : exp(-0.6 * (t - 7))
}

# Sums of the straight lines between f[0 .. n]: speed and place at the end.
function integrate(f,   k) {
  speed = place = 0
  for (k = 0; k < n; ++k) {
    place += dt * speed + dt * dt / 6 * (2 * f[k] + f[k + 1])
    speed += dt / 2 * (f[k] + f[k + 1])
  }
}

# a[0 .. n] of one direction.
function shake(largest,   k, i, x, v, y, u, w, ground, wg, wf, h, d, c1, c2, most, t) {
  wg = 2 * pi * 2.2; wf = 2 * pi * 0.35; h = dt / 4
  x = v = y = u = 0
  for (k = 0; k <= n; ++k) {
    for (i = 0; i < 4; ++i) {
      w = normal()
      v += h * (-w - 2 * 0.5 * wg * v - wg * wg * x); x += h * v
      ground = -2 * 0.5 * wg * v - wg * wg * x
      u += h * (-ground - 2 * 0.7 * wf * u - wf * wf * y); y += h * u
    }
    t = k * dt
    a[k] = envelope(t) * (ground - 2 * 0.7 * wf * u - wf * wf * y) * (k > 0 && k < n)
    one[k] = sin(pi * t / T) ^ 2
    two[k] = one[k] * t / T
  }
  integrate(one); d11 = speed; d21 = place
  integrate(two); d12 = speed; d22 = place
  integrate(a)
  d = d11 * d22 - d12 * d21
  c1 = (speed * d22 - d12 * place) / d
  c2 = (d11 * place - speed * d21) / d
  most = 0
  for (k = 0; k <= n; ++k) {
    a[k] -= c1 * one[k] + c2 * two[k]
    if (a[k] > most) most = a[k]
    if (-a[k] > most) most = -a[k]
  }
  for (k = 0; k <= n; ++k) a[k] *= largest / most
}

BEGIN {
  pi = atan2(0, -1); T = 14; dt = 0.02; n = 700
  seed = 1940; shake(2.5); for (k = 0; k <= n; ++k) ax[k] = a[k]
  seed = 1985; shake(2.5); for (k = 0; k <= n; ++k) ay[k] = a[k]
  seed = 1995; shake(1.2)
  print "# A synthetic earthquake, made by assets/recipes/earthquake.awk"
  print "t,ax,ay,az"
  for (k = 0; k <= n; ++k) printf "%.2f,%.9f,%.9f,%.9f\n", k * dt, ax[k], ay[k], a[k]
}
