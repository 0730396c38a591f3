# A bar of tetrahedra along x, n by m by m cells and six tetrahedra a cell around its main diagonal, as
# MSH 2.2; with `height` and `l` a slab of n by m by l cells; with `centred` its middle is the origin.
#
#     awk -v length_x=0.4 -v width=0.1 -v n=8 -v m=2 -f assets/recipes/bar.awk > assets/meshes/bar.msh
#     awk -v length_x=1 -v width=1 -v height=0.04 -v n=6 -v m=6 -v l=1 -f assets/recipes/bar.awk > assets/meshes/mat.msh
#     awk -v length_x=0.02 -v width=0.06 -v height=0.14 -v n=2 -v m=3 -v l=8 -v centred=1 -f assets/recipes/bar.awk > assets/meshes/finger.msh
#     awk -v length_x=0.012 -v width=0.05 -v height=0.1 -v n=1 -v m=2 -v l=4 -v centred=1 -f assets/recipes/bar.awk > assets/meshes/domino.msh
function vertex(i, j, k) { return (i * (m + 1) + j) * (l + 1) + k + 1 }

function tet(a, b, c, d) { printf "%d 4 2 1 1 %d %d %d %d\n", ++count, a, b, c, d }

BEGIN {
  if (!l) { l = m; height = width }
  middle = centred ? 0.5 : 0
  print "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n" (n + 1) * (m + 1) * (l + 1)
  for (i = 0; i <= n; ++i)
    for (j = 0; j <= m; ++j)
      for (k = 0; k <= l; ++k)
        printf "%d %.9g %.9g %.9g\n", vertex(i, j, k), length_x * (i / n - middle),
          width * (j / m - middle), height * (k / l - middle)
  print "$EndNodes\n$Elements\n" 6 * n * m * l
  for (i = 0; i < n; ++i)
    for (j = 0; j < m; ++j)
      for (k = 0; k < l; ++k) {
        a = vertex(i, j, k); h = vertex(i + 1, j + 1, k + 1)
        p[1] = vertex(i + 1, j, k); p[2] = vertex(i + 1, j + 1, k); p[3] = vertex(i, j + 1, k)
        p[4] = vertex(i, j + 1, k + 1); p[5] = vertex(i, j, k + 1); p[6] = vertex(i + 1, j, k + 1)
        for (q = 1; q <= 6; ++q) tet(a, p[q], p[q % 6 + 1], h)
      }
  print "$EndElements"
}
