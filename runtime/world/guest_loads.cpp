#include "runtime/world/guest_loads.h"

#include <string>
#include <utility>
#include <vector>

#include "common/overflow.h"
#include "runtime/world/guest_points.h"

namespace tremolo {

Status add_guest_loads(MixedGuests& guests, std::size_t guest, std::span<const SceneLoad> loads) {
  for (const SceneLoad& load : loads) {
    if (load.signal.kind == SignalKind::kNone) continue;
    const std::string of = "body '" + guests.name(guest) + "': ";
    if (Status s = check_signal_size(load.signal); !s) return content_error(of + s.error().message);
    if (load.at.empty())
      return content_error(of + "a load on " +
                           (guests.tets(guest) != nullptr ? "a body of tetrahedra" : "a cloth") +
                           " needs `at` and `force`");
    Result<std::vector<PointPush>> pushes = guest_pushes(guests, guest, load.at, load.force);
    if (!pushes) return Error{pushes.error().kind, of + pushes.error().message};
    for (PointPush& push : *pushes) push.force *= load.scale;
    GuestLoad wanted{
        .guest = guest, .pushes = std::move(*pushes), .signal = load.signal, .table = load.table};
    if (Status s = guests.add_load(std::move(wanted)); !s) return s;
  }
  return Success{};
}

}  // namespace tremolo
