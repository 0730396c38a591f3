# A ball of tetrahedra: a cube's grid of n cells a side, six tetrahedra a cell, whose shells are blown up
# to spheres (x |x|_max / |x|), as MSH 2.2.
#
#     awk -v radius=0.03 -v n=4 -f assets/recipes/ball.awk > assets/meshes/ball.msh
function vertex(i, j, k) { return (i * (n + 1) + j) * (n + 1) + k + 1 }

function tet(a, b, c, d) { printf "%d 4 2 1 1 %d %d %d %d\n", ++count, a, b, c, d }

function largest(x, y, z) {
  x = x < 0 ? -x : x; y = y < 0 ? -y : y; z = z < 0 ? -z : z
  return x > y ? (x > z ? x : z) : (y > z ? y : z)
}

BEGIN {
  print "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n" (n + 1) ^ 3
  for (i = 0; i <= n; ++i)
    for (j = 0; j <= n; ++j)
      for (k = 0; k <= n; ++k) {
        x = 2 * i / n - 1; y = 2 * j / n - 1; z = 2 * k / n - 1
        length2 = x * x + y * y + z * z
        scale = length2 > 0 ? radius * largest(x, y, z) / sqrt(length2) : 0
        printf "%d %.9g %.9g %.9g\n", vertex(i, j, k), scale * x, scale * y, scale * z
      }
  print "$EndNodes\n$Elements\n" 6 * n ^ 3
  # Along the diagonal away from the middle, so that no tetrahedron is flattened on a sphere.
  for (i = 0; i < n; ++i)
    for (j = 0; j < n; ++j)
      for (k = 0; k < n; ++k) {
        u = 2 * i < n ? 1 : 0; v = 2 * j < n ? 1 : 0; w = 2 * k < n ? 1 : 0
        flip = (u + v + w) % 2
        a = vertex(i + u, j + v, k + w); h = vertex(i + 1 - u, j + 1 - v, k + 1 - w)
        p[1] = vertex(i + 1 - u, j + v, k + w); p[2] = vertex(i + 1 - u, j + 1 - v, k + w)
        p[3] = vertex(i + u, j + 1 - v, k + w); p[4] = vertex(i + u, j + 1 - v, k + 1 - w)
        p[5] = vertex(i + u, j + v, k + 1 - w); p[6] = vertex(i + 1 - u, j + v, k + 1 - w)
        for (m = 1; m <= 6; ++m) {
          next_one = m % 6 + 1
          if (flip) tet(a, p[next_one], p[m], h); else tet(a, p[m], p[next_one], h)
        }
      }
  print "$EndElements"
}
