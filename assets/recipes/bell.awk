# A bell of tetrahedra, mouth down, as MSH 2.2: a wall of even thickness around half an ellipsoid that
# flares at its rim, open at the crown, where it hangs. A grid of one cell through the wall, `along` from
# crown to rim and `around`, six tetrahedra a cell.
#
#     awk -v radius=0.05 -v height=0.09 -v wall=0.004 -v along=9 -v around=24 \
#         -f assets/recipes/bell.awk > assets/meshes/bell.msh
function vertex(i, j, k) { return (i * (around) + j % around) * 2 + k + 1 }

function tet(a, b, c, d) { printf "%d 4 2 1 1 %d %d %d %d\n", ++count, a, b, c, d }

# The middle of the wall at s from 0 (crown) to 1 (rim).
function across(s) { return radius * (sin(0.2 + 1.25 * s) + 0.35 * s ^ 6) }

function up(s) { return height * cos(0.2 + 1.37 * s) }

BEGIN {
  pi = atan2(0, -1)
  print "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n" (along + 1) * around * 2
  for (i = 0; i <= along; ++i) {
    s = i / along
    dr = (across(s + 1e-4) - across(s - 1e-4)); dz = (up(s + 1e-4) - up(s - 1e-4))
    slope = sqrt(dr * dr + dz * dz)
    for (j = 0; j < around; ++j)
      for (k = 0; k < 2; ++k) {
        out = (k - 0.5) * wall
        r = across(s) - out * dz / slope; z = up(s) + out * dr / slope
        printf "%d %.9g %.9g %.9g\n", vertex(i, j, k), r * cos(2 * pi * j / around), r * sin(2 * pi * j / around), z
      }
  }
  print "$EndNodes\n$Elements\n" 6 * along * around
  for (i = 0; i < along; ++i)
    for (j = 0; j < around; ++j) {
      a = vertex(i, j, 0); h = vertex(i + 1, j + 1, 1)
      p[1] = vertex(i + 1, j, 0); p[2] = vertex(i + 1, j + 1, 0); p[3] = vertex(i, j + 1, 0)
      p[4] = vertex(i, j + 1, 1); p[5] = vertex(i, j, 1); p[6] = vertex(i + 1, j, 1)
      for (m = 1; m <= 6; ++m) tet(a, p[m % 6 + 1], p[m], h)
    }
  print "$EndElements"
}
