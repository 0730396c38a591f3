# A strip of NX x NY cells in the plane, one layer of tetrahedra thick, as a VegaFEM .veg file:
#
#   awk -v nx=70 -v ny=4 -v box="0 0.35 0 0.02" -v thick=0.005 [-v arc="X Y R"] -f strip.awk
#
# box: x and y from, to; thick: in z, from 0. With arc the left end lies on that circle about (X, Y)
# and the columns of cells share what is left. Every cell is cut into four triangles around its
# centre, every triangle drawn out into three tetrahedra. The pattern is the same on both faces: with
# u_z held a field that does not depend on z is one of linear triangles, and it very nearly solves
# the tetrahedra's problem.
BEGIN {
  n = triangles = 0
  split(box, b, " ")
  round = split(arc, c, " ") == 3
  for (i = 0; i <= nx; i++)
    for (j = 0; j <= ny; j++) {
      y[n] = b[3] + (b[4] - b[3]) * j / ny
      left = round ? c[1] + sqrt(c[3] ^ 2 - (y[n] - c[2]) ^ 2) : b[1]
      x[n++] = left + (b[2] - left) * i / nx
    }
  for (i = 0; i < nx; i++)
    for (j = 0; j < ny; j++) {
      corner[0] = i * (ny + 1) + j
      corner[1] = corner[0] + ny + 1
      corner[2] = corner[1] + 1
      corner[3] = corner[0] + 1
      for (k = 0; k < 4; k++) {
        x[n] += x[corner[k]] / 4
        y[n] += y[corner[k]] / 4
        first[triangles] = corner[k]
        second[triangles] = corner[(k + 1) % 4]
        third[triangles++] = n  # the largest of the three
      }
      n++
    }
  print "*VERTICES"
  print 2 * n, 3, 0, 0
  for (v = 0; v < 2 * n; v++)
    printf "%d %.15g %.15g %.15g\n", v + 1, x[v % n], y[v % n], v < n ? 0 : thick
  print "*ELEMENTS"
  print "TET"
  print 3 * triangles, 4, 0
  for (t = 0; t < triangles; t++) {
    # Rising numbers, so that neighbours cut their common wall in the same way.
    swapped = first[t] > second[t]
    p = swapped ? second[t] : first[t]
    q = swapped ? first[t] : second[t]
    r = third[t]
    tetrahedron(p, q, r, r + n)
    tetrahedron(p, q, r + n, q + n)
    tetrahedron(p, q + n, r + n, p + n)
  }
}

# p, q, r, s: turned over where the triangle is.
function tetrahedron(p, q, r, s) {
  if (swapped)
    print ++e, p + 1, r + 1, q + 1, s + 1
  else
    print ++e, p + 1, q + 1, r + 1, s + 1
}
