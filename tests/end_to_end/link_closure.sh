#!/bin/sh
# What the runtime's program loads, directly or through others, must hold no solver, no MPI, no mesh
# importer. usage: link_closure.sh PROGRAM
set -eu
closure=$(ldd "$1")
printf '%s\n' "$closure"
if printf '%s\n' "$closure" | grep -Ei 'petsc|slepc|mpi|metis|mumps|cholmod|assimp|cgal|gmp|mpfr|blas'; then
  echo "the runtime must not depend on these" >&2
  exit 1
fi
# The static libraries are not in ldd's list: no symbol of theirs may be wanted either.
if nm -C "$1" | grep -E ' (Petsc|Slepc|EPS|MPI_|METIS_|aiImport|Assimp::)'; then
  echo "symbols of the precompute in the runtime" >&2
  exit 1
fi
