#include "kernel/plan/build_image.h"

#include <cassert>
#include <cstring>
#include <memory>
#include <new>

#include "kernel/plan/plan_image.h"

namespace unlatch {
namespace {

constexpr std::align_val_t kAlignment{kImageAlignment};

std::size_t round_up(std::size_t bytes) { return (bytes + kImageAlignment - 1) / kImageAlignment * kImageAlignment; }

// The bytes between members would have arbitrary values otherwise.
template <class T>
void clear_padding([[maybe_unused]] T& record) {
#if defined(__GNUC__) && !defined(__clang__)
  __builtin_clear_padding(&record);
#endif
}

struct FreeImage {
  void operator()(std::byte* memory) const { ::operator delete(memory, kAlignment); }
};

struct OwnedPlan {
  std::unique_ptr<std::byte, FreeImage> memory;
  PlanData data;
};

void write_image(const PlanDraft& draft, std::span<std::byte> image) {
  ImageHeader header;
  std::memset(static_cast<void*>(&header), 0, sizeof(header));
  std::memcpy(header.magic, kImageMagic, sizeof(kImageMagic));
  header.byte_order = kImageByteOrder;
  header.version = kImageVersion;
  header.layout = get_image_layout();
  header.bytes = image.size();
  header.numbers = draft;
  header.numbers.instruction_set = InstructionSet::kAuto;  // the machine that opens it chooses
  clear_padding(header.numbers);
  std::size_t offset = round_up(sizeof(header));
  ListPlace* place = header.lists;
  for_each_list(
      [&]<class T>(const std::vector<T>& list) {
        *place++ = {static_cast<std::uint32_t>(offset), static_cast<std::uint32_t>(list.size())};
        std::byte* to = image.data() + offset;
        for (T record : list) {
          clear_padding(record);
          std::memcpy(to, &record, sizeof(T));
          to += sizeof(T);
        }
        offset += round_up(list.size() * sizeof(T));
      },
      draft);
  std::memcpy(image.data(), &header, sizeof(header));
  header.checksum = calc_words_hash(image.subspan(kImageChecked));
  std::memcpy(image.data() + offsetof(ImageHeader, checksum), &header.checksum, sizeof(header.checksum));
}

std::size_t count_bytes(const PlanDraft& draft) {
  std::size_t bytes = round_up(sizeof(ImageHeader));
  for_each_list([&]<class T>(const std::vector<T>& list) { bytes += round_up(list.size() * sizeof(T)); }, draft);
  return bytes;
}

}  // namespace

Plan build_plan(const PlanDraft& draft) {
  const std::size_t bytes = count_bytes(draft);
  auto owned = std::make_shared<OwnedPlan>();
  owned->memory.reset(static_cast<std::byte*>(::operator new(bytes, kAlignment)));
  const std::span image(owned->memory.get(), bytes);
  std::memset(image.data(), 0, bytes);
  write_image(draft, image);
  [[maybe_unused]] const ImageStatus status = open_image(image, owned->data);
  assert(status == ImageStatus::kOk);
  return Plan(std::shared_ptr<const PlanData>(owned, &owned->data));
}

}  // namespace unlatch
