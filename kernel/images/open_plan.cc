#include <memory>
#include <new>

#include "kernel/images/plan_check.h"
#include "kernel/plan/plan_image.h"

namespace unlatch {

OpenedPlan open_plan(std::span<const std::byte> image, PlanMemory& memory) noexcept {
  static_assert(sizeof(PlanData) <= sizeof(memory.bytes));
  PlanData* const data = new (memory.bytes) PlanData;
  ImageStatus status = open_image(image, *data);
  if (status == ImageStatus::kOk && !PlanCheck(*data).is_good()) status = ImageStatus::kRange;
  if (status != ImageStatus::kOk) return {std::nullopt, status};
  return {Plan(std::shared_ptr<const PlanData>(std::shared_ptr<const PlanData>(), data)), status};  // owns nothing
}

const char* get_status_text(ImageStatus status) noexcept {
  switch (status) {
    case ImageStatus::kOk:
      return "ok";
    case ImageStatus::kMisaligned:
      return "the image does not lie at a multiple of 64 bytes: align the array that holds it";
    case ImageStatus::kNoImage:
      return "this is no plan image: give what `unlatch compile` writes";
    case ImageStatus::kByteOrder:
      return "the image was made for the other byte order: compile it on a machine with this one";
    case ImageStatus::kVersion:
      return "the image has another version of the format: compile it again with this version of unlatch";
    case ImageStatus::kLayout:
      return "the image was made for another layout of numbers or by another version of unlatch: compile it again, and "
             "build for a target that aligns numbers of 8 bytes to 8";
    case ImageStatus::kTruncated:
      return "the image is shorter than it says: copy it whole";
    case ImageStatus::kChecksum:
      return "the image's checksum is wrong, some bit has changed: copy it again";
    case ImageStatus::kRange:
      return "a list or a number of the image is out of range: compile it again";
  }
  return "unknown status";
}

}  // namespace unlatch
