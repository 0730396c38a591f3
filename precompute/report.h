// Reports of a result: on stderr, on stdout, and in the file.
#pragma once

#include <string>

#include "common/stage_log.h"
#include "precompute/pipeline.h"
#include "precompute/ranks/rank_table.h"

namespace tremolo {

// Writes the modes on the tetrahedra, unless the path is empty. data: with all rows.
void write_vtu(const std::string& path, const TetMesh& mesh, const BasisData& data, StageLog& log);

struct SolidFit;  // of --fit; null: none

// Prints one object on stdout (docs/reference.md).
void print_result(const LoadedProblem& loaded, const PrecomputeResult& result, const SolidFit* fit,
                  const StageLog& log, const RankTable& ranks);

// Prints frequencies and the stability limit of explicit methods on stderr.
void print_spectrum(const BasisData& data);

// Prints time and peak memory of all stages, and of each rank if there are several, on stderr.
void print_total(const StageLog& log, const RankTable& ranks);

// Provenance of a basis file. Returns the JSON object stored in the file. It has no times, so the
// same input gives the same file.
std::string provenance_json(const PrecomputeRequest& request, const Problem& problem,
                            const PrecomputeResult& result, const SolidFit* fit = nullptr);

}  // namespace tremolo
