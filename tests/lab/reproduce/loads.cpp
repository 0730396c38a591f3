#include "tests/lab/reproduce/loads.h"

namespace tremolo::reproduce {
namespace {

// Of the sine, so that `imexv` with its fixed split breaks off where the thesis's table 3 says:
// beam at 6.86 s (7.12 s damped), tower at 10.53 s (damped it reaches 30 s). Found by runs of 30 s
// at 3 ms, tolerance 1e-6, at 300 factors (beam, 2.1 to 2.9) and 130 (tower, 2.3 to 4).
//   tower: undamped it breaks off from 2.47 on, damped from 3.19 on. Between 2.513 and 2.532 nearly
//     all factors give 9.3 to 9.9 s, below 17 to 22 s, above 8.3 to 9.5 s; single factors in
//     between hit 10.3 s. The factor below gives 9.26 s.
//   beam: undamped it breaks off from 2.21 on, damped, now and then, from 2.61 on. Where the damped
//     run breaks off after 6 to 9 s the undamped one does after 1.8 to 3.2 s: no factor gives both
//     6.86 and 7.12 s. The factor below gives 2.73 and 6.46 s; 2.36 gives 7.35 s, and 30 s damped.
// The orbits are chaotic by then: a factor changed by 1e-6, or another compiler, moves the beam's
// times by a second or two, so they are what the table prints, not what is written here.
constexpr double kBeamSine = 2.6085;
constexpr double kTowerSine = 2.52;

}  // namespace

double load_factor(std::string_view model, SignalKind load) {
  if (load != SignalKind::kSine) return 1.0;
  if (model == "beam") return kBeamSine;
  return model == "tower" ? kTowerSine : 1.0;
}

}  // namespace tremolo::reproduce
