# A rubber duck, 0.2 m long, as one radius for each direction from a point in its neck: a surface, or a coarse
# mesh of tetrahedra that holds it. Both are a cube's grid, whose shells are blown up to spheres as those of
# ball.awk and then out to the radius. x is ahead, z up.
#
#     awk -v part=surface -v n=30 -f assets/recipes/duck.awk > build/models/duck.ply      # 12 n^2 triangles
#     awk -v part=mesh -v n=4 -f assets/recipes/duck.awk > assets/meshes/duck.msh         # 6 n^3 tetrahedra
function vertex(i, j, k) { return (i * (n + 1) + j) * (n + 1) + k + 1 }

function tet(a, b, c, d) { printf "%d 4 2 1 1 %d %d %d %d\n", ++count, a, b, c, d }

function abs(x) { return x < 0 ? -x : x }

function largest(x, y, z) {
  x = abs(x); y = abs(y); z = abs(z)
  return x > y ? (x > z ? x : z) : (y > z ? y : z)
}

# First-order distance to an ellipsoid.
function ellipsoid(x, y, z, a, b, c,  k0, k1) {
  k0 = sqrt((x / a) ^ 2 + (y / b) ^ 2 + (z / c) ^ 2)
  k1 = sqrt((x / a ^ 2) ^ 2 + (y / b ^ 2) ^ 2 + (z / c ^ 2) ^ 2)
  return k1 > 0 ? k0 * (k0 - 1) / k1 : -a
}

# Union with a fillet of width w.
function join(d, e, w,  overlap) {
  overlap = w - abs(d - e); overlap = overlap > 0 ? overlap / w : 0
  return (d < e ? d : e) - overlap ^ 3 * w / 6
}

# Body, tail, wings, head, beak; m, from the point in the neck.
function distance(x, y, z,  d) {
  d = ellipsoid(x + 0.012, y, z + 0.03, 0.082, 0.06, 0.05)
  d = join(d, ellipsoid(x + 0.085, y, z + 0.008, 0.028, 0.022, 0.02), 0.05)
  d = join(d, ellipsoid(x + 0.015, abs(y) - 0.05, z + 0.022, 0.045, 0.016, 0.024), 0.012)
  d = join(d, ellipsoid(x - 0.022, y, z - 0.045, 0.045, 0.042, 0.043), 0.04)
  return join(d, ellipsoid(x - 0.07, y, z - 0.038, 0.026, 0.022, 0.01), 0.014)
}

# Where the ray along (x, y, z), of length one, leaves the duck for the last time.
function radius(x, y, z,  far, near, step, middle) {
  step = 0.002
  for (far = 0.15; far > step && distance(far * x, far * y, far * z) > 0; far -= step) ;
  near = far; far += step
  while (far - near > 1e-9) {
    middle = (near + far) / 2
    if (distance(middle * x, middle * y, middle * z) > 0) far = middle; else near = middle
  }
  return near
}

# The direction of a node of a grid of m cells a side, into u, v, w.
function direction(i, j, k, m,  length2) {
  u = 2 * i / m - 1; v = 2 * j / m - 1; w = 2 * k / m - 1
  # Even angles instead of even cells.
  u = sin(u * pi / 4) / cos(u * pi / 4); v = sin(v * pi / 4) / cos(v * pi / 4); w = sin(w * pi / 4) / cos(w * pi / 4)
  length2 = sqrt(u * u + v * v + w * w)
  if (length2 > 0) { u /= length2; v /= length2; w /= length2 }
}

function on_hull(i, j, k, m) { return i == 0 || j == 0 || k == 0 || i == m || j == m || k == m }

function quad(a, b, c, d) { triangles = triangles "3 " a " " b " " c "\n3 " a " " c " " d "\n" }

function name(i, j, k) {
  if (!((i, j, k) in number)) {
    direction(i, j, k, n); r = radius(u, v, w)
    printf "%.7f %.7f %.7f\n", r * u, r * v, r * w
    number[i, j, k] = points++
  }
  return number[i, j, k]
}

function surface(  i, j) {
  print "ply\nformat ascii 1.0\nelement vertex", 6 * n ^ 2 + 2
  print "property float x\nproperty float y\nproperty float z\nelement face", 12 * n ^ 2
  print "property list uchar int vertex_indices\nend_header"
  for (i = 0; i < n; ++i)
    for (j = 0; j < n; ++j) {
      quad(name(0, i, j), name(0, i, j + 1), name(0, i + 1, j + 1), name(0, i + 1, j))
      quad(name(n, i, j), name(n, i + 1, j), name(n, i + 1, j + 1), name(n, i, j + 1))
      quad(name(i, 0, j), name(i + 1, 0, j), name(i + 1, 0, j + 1), name(i, 0, j + 1))
      quad(name(i, n, j), name(i, n, j + 1), name(i + 1, n, j + 1), name(i + 1, n, j))
      quad(name(i, j, 0), name(i, j + 1, 0), name(i + 1, j + 1, 0), name(i + 1, j, 0))
      quad(name(i, j, n), name(i + 1, j, n), name(i + 1, j + 1, n), name(i, j + 1, n))
    }
  printf "%s", triangles
}

# The coarse node's radius: the largest of the directions within its cells, and a tenth more.
function cage(i, j, k,  a, b, c, fine, r, most) {
  fine = 6
  for (a = fine * i - fine; a <= fine * i + fine; a += 2)
    for (b = fine * j - fine; b <= fine * j + fine; b += 2)
      for (c = fine * k - fine; c <= fine * k + fine; c += 2) {
        if (a < 0 || b < 0 || c < 0 || a > n * fine || b > n * fine || c > n * fine) continue
        if (!on_hull(a, b, c, n * fine)) continue
        direction(a, b, c, n * fine); r = radius(u, v, w)
        r *= 1 - 0.35 * ((a - fine * i) ^ 2 + (b - fine * j) ^ 2 + (c - fine * k) ^ 2) / (2 * fine ^ 2)
        if (r > most) most = r
      }
  return 1.07 * most
}

function mesh(  i, j, k, s, h, m, x, y, z, flip, a, p) {
  print "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n" (n + 1) ^ 3
  h = n / 2
  for (i = 0; i <= n; ++i)
    for (j = 0; j <= n; ++j)
      for (k = 0; k <= n; ++k) {
        s = largest(i - h, j - h, k - h)
        if (s > 0) {
          # The node of the outer shell in this direction.
          x = h + (i - h) * h / s; y = h + (j - h) * h / s; z = h + (k - h) * h / s
          if (!((x, y, z) in rim)) rim[x, y, z] = cage(x, y, z)
          direction(x, y, z, n)
          s *= rim[x, y, z] / h
        }
        printf "%d %.6f %.6f %.6f\n", vertex(i, j, k), s * u, s * v, s * w
      }
  print "$EndNodes\n$Elements\n" 6 * n ^ 3
  # As in ball.awk.
  for (i = 0; i < n; ++i)
    for (j = 0; j < n; ++j)
      for (k = 0; k < n; ++k) {
        x = 2 * i < n ? 1 : 0; y = 2 * j < n ? 1 : 0; z = 2 * k < n ? 1 : 0
        flip = (x + y + z) % 2
        a = vertex(i + x, j + y, k + z); h = vertex(i + 1 - x, j + 1 - y, k + 1 - z)
        p[1] = vertex(i + 1 - x, j + y, k + z); p[2] = vertex(i + 1 - x, j + 1 - y, k + z)
        p[3] = vertex(i + x, j + 1 - y, k + z); p[4] = vertex(i + x, j + 1 - y, k + 1 - z)
        p[5] = vertex(i + x, j + y, k + 1 - z); p[6] = vertex(i + 1 - x, j + y, k + 1 - z)
        for (m = 1; m <= 6; ++m)
          if (flip) tet(a, p[m % 6 + 1], p[m], h); else tet(a, p[m], p[m % 6 + 1], h)
      }
  print "$EndElements"
}

BEGIN {
  pi = atan2(0, -1)
  if (part == "mesh") mesh(); else surface()
}
