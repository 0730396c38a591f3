// VegaFEM's .cub and .U. What is read is written back to the same bytes.
#include "formats/vega/reduced_files.h"
#include "tests/fuzz/harness.h"

void tremolo::fuzz::read_input(std::string_view bytes) {
  const Result<ReducedForces> forces = read_cub(bytes, "input.cub");
  check_error(forces);
  if (forces) {
    const Result<std::string> written = cub_bytes(*forces);
    if (!written || *written != bytes) finding("a .cub that is written back otherwise");
  }
  const Result<Eigen::MatrixXd> basis = read_basis_matrix(bytes, "input.U");
  check_error(basis);
  if (basis) {
    if (!basis->allFinite()) finding("a number that is not finite");
    const Result<std::string> written = basis_matrix_bytes(*basis);
    if (!written || *written != bytes) finding("a .U that is written back otherwise");
  }
}
