#include "kernel/plan/plan_image.h"

#include <cstring>

#include "kernel/simd/instruction_set.h"

namespace unlatch {
namespace {

bool is_aligned(const std::byte* place) { return reinterpret_cast<std::uintptr_t>(place) % kImageAlignment == 0; }

const ImageHeader& get_header(std::span<const std::byte> image) {
  return *reinterpret_cast<const ImageHeader*>(image.data());
}

// Reads no member of the header that may lie behind the image's end.
ImageStatus check_header(std::span<const std::byte> image) {
  const ImageHeader& header = get_header(image);
  if (image.size() < offsetof(ImageHeader, layout)) return ImageStatus::kTruncated;
  if (std::memcmp(header.magic, kImageMagic, sizeof(kImageMagic)) != 0) return ImageStatus::kNoImage;
  if (header.byte_order != kImageByteOrder) return ImageStatus::kByteOrder;
  if (header.version != kImageVersion) return ImageStatus::kVersion;
  if (image.size() < kImageChecked) return ImageStatus::kTruncated;
  if (header.layout != get_image_layout()) return ImageStatus::kLayout;
  if (image.size() < sizeof(ImageHeader) || header.bytes > image.size()) return ImageStatus::kTruncated;
  if (header.bytes < sizeof(ImageHeader) || header.bytes % 8 != 0) return ImageStatus::kRange;
  const std::span checked = image.subspan(kImageChecked, static_cast<std::size_t>(header.bytes) - kImageChecked);
  return calc_words_hash(checked) == header.checksum ? ImageStatus::kOk : ImageStatus::kChecksum;
}

template <class T>
bool find_list(std::span<const std::byte> image, const ListPlace& place, std::span<const T>& list) {
  const std::uint64_t size = std::uint64_t{place.count} * sizeof(T);
  if (place.offset % kImageAlignment != 0 || place.offset > image.size() || size > image.size() - place.offset)
    return false;
  list = {reinterpret_cast<const T*>(image.data() + place.offset), place.count};
  return true;
}

}  // namespace

ImageStatus open_image(std::span<const std::byte> image, PlanData& plan) noexcept {
  if (!is_aligned(image.data())) return ImageStatus::kMisaligned;
  if (const ImageStatus status = check_header(image); status != ImageStatus::kOk) return status;
  const ImageHeader& header = get_header(image);
  plan.image = image.first(static_cast<std::size_t>(header.bytes));
  bool good = true;
  const ListPlace* place = header.lists;
  for_each_list([&](auto& list) { good = find_list(plan.image, *place++, list) && good; }, plan);
  if (!good) return ImageStatus::kRange;
  static_cast<PlanNumbers&>(plan) = header.numbers;
  const InstructionSet wanted = plan.options.instruction_set;
  plan.instruction_set = resolve(is_supported(wanted) ? wanted : InstructionSet::kAuto);
  return ImageStatus::kOk;
}

}  // namespace unlatch
