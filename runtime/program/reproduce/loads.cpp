#include "runtime/program/reproduce/loads.h"

namespace tremolo::reproduce {
namespace {

// Of the sine, so that `imexv` with its fixed split breaks off where the thesis's table 3 says:
// beam at 6.86 s (7.12 s damped), tower at 10.53 s (damped it reaches 30 s). Found by running both
// models over 2 000 to 10 000 steps of 3 ms, tolerance 1e-6, at 300 factors (beam, 2.1 to 2.9) and
// 80 (tower, 2.3 to 4) and taking the nearest.
//   tower: undamped it breaks off from 2.47 on, damped from 3.19 on; between 2.51 and 2.6 after 8.3
//     to 11.4 s. At the factor below after 10.32 s.
//   beam: undamped it breaks off from 2.21 on, damped from 2.63 on (and at 2.61); where the damped
//     run breaks off after 7 s the undamped one does after 2 to 3 s. No factor gives both 6.86 and
//     7.12 s; the factor below gives 2.78 s and 6.26 s, 2.37 alone gives 7.3 s and 30 s.
// The times move by a tenth for a thousandth of the factor: the orbit is chaotic by then.
constexpr double kBeamSine = 2.60979;
constexpr double kTowerSine = 2.58475;

}  // namespace

double load_factor(std::string_view model, SignalKind load) {
  if (load != SignalKind::kSine) return 1.0;
  if (model == "beam") return kBeamSine;
  return model == "tower" ? kTowerSine : 1.0;
}

}  // namespace tremolo::reproduce
