// Gathering of the basis for the file: each rank holds the rows of its nodes, rank 0 writes, and no
// rank holds all rows at once.
#pragma once

#include "formats/basis/basis_writer.h"
#include "precompute/embedding/embedding.h"
#include "precompute/fem/dof_map.h"

namespace tremolo {

// References to a distributed basis. rows: at the part's vertices, 3 a vertex x r
// (expand_to_vertices).
struct SpreadBasis {
  const TetMesh& mesh;  // the whole mesh
  const Embedding& embedding;
  const DofMap& map;
  const LocalDofs& local;
  const BasisRows& rows;
};

// gathered_rows() returns, on rank 0, the sources from which the writer reads the rows of data's
// blocks; meanwhile all other ranks must be in serve_rows(). data: vertex ids of the blocks, the
// same on all ranks.
RowSources gathered_rows(const SpreadBasis& basis, const BasisData& data);
void serve_rows(const SpreadBasis& basis, const BasisData& data);

// Gathers all rows on rank 0, for callers that need all of them at once: into the data's blocks, or
// into three arrays for the blocks of the data's vertices. Collective.
struct GatheredRows {
  BasisRows surface, render, interior;
};
GatheredRows gather_rows(const SpreadBasis& basis, const BasisData& data);
void collect_rows(const SpreadBasis& basis, BasisData& data);

}  // namespace tremolo
