#include "runtime/bodies/tets/solve/tet_stage.h"

#include <array>
#include <string>
#include <utility>

namespace tremolo {
namespace {

constexpr std::array<std::pair<std::string_view, TetMethod>, 4> kTetMethods = {
    {{"implicit-euler", TetMethod::kImplicitEuler},
     {"midpoint", TetMethod::kMidpoint},
     {"newmark", TetMethod::kNewmark},
     {"bdf2", TetMethod::kBdf2}}};

}  // namespace

Result<TetMethod> parse_tet_method(std::string_view name) {
  for (const auto& [known, method] : kTetMethods)
    if (known == name) return method;
  return usage_error("unknown integrator '" + std::string(name) +
                     "' of tetrahedra: implicit-euler, midpoint, newmark or bdf2");
}

const char* tet_method_name(TetMethod method) {
  for (const auto& [name, known] : kTetMethods)
    if (known == method) return name.data();
  return "";
}

void begin_stage(TetMethod method, double h, const TetMotion& now, const TetMotion* before,
                 TetStage& stage) {
  if (method == TetMethod::kBdf2 && before == nullptr) method = TetMethod::kImplicitEuler;
  stage.method = method;
  stage.from = now.x;
  switch (method) {
    case TetMethod::kImplicitEuler:
      stage.rate = 1.0 / h;
      stage.inertial = h * now.v;
      break;
    case TetMethod::kMidpoint:
      stage.rate = 2.0 / h;
      stage.inertial = 0.5 * h * now.v;
      break;
    case TetMethod::kNewmark:
      stage.rate = 2.0 / h;
      stage.from += 0.5 * h * now.v;
      stage.inertial = 0.5 * h * now.v + 0.25 * h * h * now.a;
      break;
    case TetMethod::kBdf2:
      stage.rate = 1.5 / h;
      stage.from += (now.x - before->x) / 3.0;
      stage.inertial = (4.0 * now.v - before->v) / (3.0 * stage.rate);
      break;
  }
}

void end_stage(const TetStage& stage, const Eigen::VectorXd& d, TetMotion& now, TetMotion& before) {
  before.x = now.x;
  before.v = now.v;
  if (stage.method == TetMethod::kMidpoint) {
    now.x += 2.0 * d;
    now.v = 2.0 * stage.rate * d - before.v;
    return;
  }
  if (stage.method == TetMethod::kNewmark) now.a = (stage.rate * stage.rate) * (d - stage.inertial);
  now.x = stage.from + d;
  now.v = stage.rate * d;
}

}  // namespace tremolo
