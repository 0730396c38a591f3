# A box of NX NY NZ cells, six tetrahedra a cell around its diagonal, as .veg:
# awk -v cells="NX NY NZ LX LY LZ" -f beam.awk
BEGIN {
  split(cells, c, " "); nx = c[1]; ny = c[2]; nz = c[3]
  print "*VERTICES"; print (nx + 1) * (ny + 1) * (nz + 1), 3, 0, 0
  id = 0
  for (i = 0; i <= nx; i++) for (j = 0; j <= ny; j++) for (k = 0; k <= nz; k++)
    printf "%d %.9g %.9g %.9g\n", ++id, c[4] * i / nx, c[5] * j / ny, c[6] * k / nz
  print "*ELEMENTS"; print "TET"; print 6 * nx * ny * nz, 4, 0
  sx = (ny + 1) * (nz + 1); sy = nz + 1; sz = 1
  # Steps along the three axes in every order; odd orders have their last corners exchanged.
  split(sx " " sx " " sy " " sy " " sz " " sz, a, " ")
  split(sy " " sz " " sx " " sz " " sx " " sy, b, " ")
  split("0 1 1 0 0 1", odd, " ")
  id = 0
  for (i = 0; i < nx; i++) for (j = 0; j < ny; j++) for (k = 0; k < nz; k++) {
    v = i * sx + j * sy + k + 1; w = v + sx + sy + sz
    for (o = 1; o <= 6; o++) {
      p = v + a[o]; q = p + b[o]
      if (odd[o]) print ++id, v, p, w, q; else print ++id, v, p, q, w
    }
  }
}
