# A bar of tetrahedra along x, n by m by m cells and six tetrahedra a cell around its main diagonal, as
# MSH 2.2.
#
#     awk -v length_x=0.4 -v width=0.1 -v n=8 -v m=2 -f assets/recipes/bar.awk > assets/meshes/bar.msh
function vertex(i, j, k) { return (i * (m + 1) + j) * (m + 1) + k + 1 }

function tet(a, b, c, d) { printf "%d 4 2 1 1 %d %d %d %d\n", ++count, a, b, c, d }

BEGIN {
  print "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n" (n + 1) * (m + 1) ^ 2
  for (i = 0; i <= n; ++i)
    for (j = 0; j <= m; ++j)
      for (k = 0; k <= m; ++k)
        printf "%d %.9g %.9g %.9g\n", vertex(i, j, k), length_x * i / n, width * j / m, width * k / m
  print "$EndNodes\n$Elements\n" 6 * n * m ^ 2
  for (i = 0; i < n; ++i)
    for (j = 0; j < m; ++j)
      for (k = 0; k < m; ++k) {
        a = vertex(i, j, k); h = vertex(i + 1, j + 1, k + 1)
        p[1] = vertex(i + 1, j, k); p[2] = vertex(i + 1, j + 1, k); p[3] = vertex(i, j + 1, k)
        p[4] = vertex(i, j + 1, k + 1); p[5] = vertex(i, j, k + 1); p[6] = vertex(i + 1, j, k + 1)
        for (q = 1; q <= 6; ++q) tet(a, p[q], p[q % 6 + 1], h)
      }
  print "$EndElements"
}
