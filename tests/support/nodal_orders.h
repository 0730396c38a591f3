// The orders of the methods of masses in space, as the literature has them.
#pragma once

#include <string_view>
#include <utility>

namespace tremolo::testing {

inline constexpr std::pair<std::string_view, double> kNodalOrders[] = {
    {"explicit-euler", 1.0},
    {"symplectic-euler", 1.0},
    {"implicit-euler", 1.0},
    {"implicit-euler-sweep", 1.0},
    {"implicit-euler-linear", 1.0},
    {"explicit-midpoint", 2.0},
    {"midpoint", 2.0},
    {"newmark", 2.0},
    {"bdf2", 2.0},
    {"imex", 2.0},
    {"energy", 2.0},
    {"rk4", 4.0}};

}  // namespace tremolo::testing
