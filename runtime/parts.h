// The parts that a build has. Libraries and programs have all parts. A build with TREMOLO_CORE, the
// smallest module of a page (runtime/apps/web/engine), has only bodies with a fixed support, and
// grabs. The values are known to the compiler, which then omits code that only an absent part
// needs. Builds of both kinds are never linked together.
#pragma once

#include <memory>
#include <type_traits>

namespace tremolo {

#if defined(TREMOLO_CORE)
inline constexpr bool kHasFrames = false;     // bodies that are driven or free, gravity
inline constexpr bool kHasColliders = false;  // and bodies as colliders
#else
inline constexpr bool kHasFrames = true;
inline constexpr bool kHasColliders = true;
#endif

// AbsentPart replaces a pointer to an absent part and is always null.
template <class Part>
struct AbsentPart {
  AbsentPart() = default;
  AbsentPart(Part*) {}
  AbsentPart(std::unique_ptr<Part>) {}
  AbsentPart(std::shared_ptr<Part>) {}

  explicit operator bool() const { return false; }
  bool operator==(std::nullptr_t) const { return true; }
  Part* get() const { return nullptr; }
  void reset() {}
  // These two are only reached after a condition on the pointer, which is never true.
  Part* operator->() const { __builtin_unreachable(); }
  Part& operator*() const { __builtin_unreachable(); }
};

// A pointer to a part that moves with a frame, and the types that own it.
template <class Part>
using FramePointer = std::conditional_t<kHasFrames, Part*, AbsentPart<Part>>;
template <class Part>
using FrameOwner = std::conditional_t<kHasFrames, std::unique_ptr<Part>, AbsentPart<Part>>;
template <class Part>
using FrameSharer = std::conditional_t<kHasFrames, std::shared_ptr<Part>, AbsentPart<Part>>;

}  // namespace tremolo
