# Sourced by the cases with Turek & Hron's bar: E = 1.4e6 Pa, nu = 0.4, 1000 kg/m^3; the cylinder is
# centred at (0.2, 0.2) and has a radius of 0.05 m, A lies at (0.6, 0.2).

# bar CELLS THICK: OUT/bar_CELLS.veg; $arc selects the clamped vertices.
bar() {
  strip "bar_$1" $((35 * $1 / 2)) "$1" '0.25 0.6 0.19 0.21' "$2" '0.2 0.2 0.05'
  # A quarter of a cell beyond the cylinder.
  arc="sphere:0.2,0.2,$(calc "$2 / 2"),$(calc "sqrt((0.05 + 0.005 / $1) ^ 2 + ($2 / 2) ^ 2)")"
}

# Nothing moves along z.
plane_strain="--young 1.4e6 --poisson 0.4 --density 1000 --fix-z z>=0%"

# wide_bar CELLS: OUT/wide_CELLS.veg, a bar so wide that what bends and twists it the other way is
# fast; $wide is what it is made of and held by, $wide_end selects A. Its material answers along z to
# nothing that happens in the plane, and in the plane as the other does in plane strain: with
# E' = E / (1 - nu^2) and nu' = nu / (1 - nu) the in-plane part of S = C E is the same. So nothing
# need be held along z, which a basis file could not.
wide_bar() {
  strip "wide_$1" $((35 * $1 / 2)) "$1" '0.25 0.6 0.19 0.21' 0.2 '0.2 0.2 0.05'
  local plane=e1=1666666.6666666667,e2=1666666.6666666667,nu12=0.66666666666666667,g12=5e5
  wide=(--material "x>=0%: $plane, e3=1.4e6, nu23=0, nu31=0, g23=5e5, g31=5e5, density=1000"
    --fix "sphere:0.2,0.2,0.1,$(calc "sqrt((0.05 + 0.005 / $1) ^ 2 + 0.01)")")
  wide_end=near:0.6,0.2,0
}
