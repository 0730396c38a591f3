# A block of NX x NY x NZ cells, each cut into six tetrahedra about its diagonal, as a VegaFEM .veg
# file:
#
#   awk -v nx=16 -v ny=16 -v nz=1 -v size="1 1 0.01" [-v radius=R] [-v mirrored=1] -f block.awk
#
# size: its edges, from the origin. With a radius it is a hoop: x runs once around the circle of that
# radius and closes, y is the width along the axis, z the thickness, half of it inside the circle.
# Mirrored: a cell is the mirror image of its neighbours, so that a block with even numbers of cells is
# symmetric in x, y and z; without, the cut has one direction everywhere.
BEGIN {
  split(size, s, " ")
  columns = radius ? nx : nx + 1
  turn = 2 * atan2(0, -1) / nx
  print "*VERTICES"
  print columns * (ny + 1) * (nz + 1), 3, 0, 0
  for (k = 0; k <= nz; k++)
    for (j = 0; j <= ny; j++)
      for (i = 0; i < columns; i++) {
        y = s[2] * j / ny
        z = s[3] * k / nz
        if (radius) {
          r = radius + z - s[3] / 2
          printf "%d %.15g %.15g %.15g\n", ++v, r * cos(turn * i), y, r * sin(turn * i)
        } else
          printf "%d %.15g %.15g %.15g\n", ++v, s[1] * i / nx, y, z
      }
  print "*ELEMENTS"
  print "TET"
  print 6 * nx * ny * nz, 4, 0
  split("xyz xzy yxz yzx zxy zyx", ways, " ")
  for (k = 0; k < nz; k++)
    for (j = 0; j < ny; j++)
      for (i = 0; i < nx; i++)
        for (w = 1; w <= 6; w++) tetrahedron(ways[w])
}

function vertex(a, b, c) { return 1 + (c * (ny + 1) + b) * columns + a % columns }

# From corner (i, j, k) to the opposite one along the axes in the order of `way`. The orders that are
# odd, and all of a hoop, which turns x, y, z to the left hand, are turned over.
function tetrahedron(way,    a, b, c, n, step, id, odd, di, dj, dk) {
  di = dj = dk = 1
  if (mirrored) { di -= 2 * (i % 2); dj -= 2 * (j % 2); dk -= 2 * (k % 2) }
  a = i + (di < 0); b = j + (dj < 0); c = k + (dk < 0)
  id[0] = vertex(a, b, c)
  for (n = 1; n <= 3; n++) {
    step = substr(way, n, 1)
    if (step == "x") a += di
    if (step == "y") b += dj
    if (step == "z") c += dk
    id[n] = vertex(a, b, c)
  }
  odd = way == "xzy" || way == "yxz" || way == "zyx"
  if (di * dj * dk < 0) odd = !odd
  if (odd != (radius > 0)) print ++e, id[0], id[2], id[1], id[3]
  else print ++e, id[0], id[1], id[2], id[3]
}
