// Plan images: a compiled plan as one block of bytes, which is used where it lies: in flash, in a file that is mapped.
// compile_plan() makes one for every plan (Plan::get_image()); open_plan() makes a plan of one again, on any machine
// with the same byte order and layout of numbers, whatever its word size. kernel/TARGETS.md shows it on a target.
//
//   alignas(unlatch::kImageAlignment) static const std::byte image[] = {…};   // what `unlatch compile` wrote
//   static unlatch::PlanMemory memory;
//   const unlatch::OpenedPlan opened = unlatch::open_plan(image, memory);
//   if (!opened.plan) halt(unlatch::get_status_text(opened.status));
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "unlatch/plan.h"

namespace unlatch {

inline constexpr std::size_t kImageAlignment = 64;  // bytes, of an image's place in memory

// Result of opening an image.
enum class ImageStatus : std::int32_t {
  kOk = 0,      // there is a plan
  kMisaligned,  // it does not lie at a multiple of kImageAlignment
  kNoImage,     // something else than a plan image
  kByteOrder,   // made for the other byte order
  kVersion,     // of another version of the format
  kLayout,      // made for another layout of numbers, or by another version of the kernel
  kTruncated,   // shorter than it says
  kChecksum,    // some bit has changed
  kRange,       // a list or a number of it is out of range
};
// The status in words, with what mends it.
const char* get_status_text(ImageStatus status) noexcept;

// Memory of an opened plan's view of its image; the caller's. Its content does not matter.
struct PlanMemory {
  alignas(kImageAlignment) std::byte bytes[2048];
};

// Result of open_plan().
struct OpenedPlan {
  std::optional<Plan> plan;               // absent unless the status is kOk
  ImageStatus status = ImageStatus::kOk;  // why there is no plan
};

// Checks the image and makes a plan of it; no allocation; linear in its size. Image and memory must outlive the plan
// and its copies.
OpenedPlan open_plan(std::span<const std::byte> image, PlanMemory& memory) noexcept;

}  // namespace unlatch
