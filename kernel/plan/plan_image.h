// The image of a plan: a header, then its lists, each at a multiple of kImageAlignment, in the order of
// for_each_list(). Places are counted from the beginning of the image, and no record holds a pointer or a number whose
// size depends on the machine, so that a target with another word size uses what the host wrote.
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "kernel/math/hash.h"
#include "kernel/plan/plan_lists.h"
#include "unlatch/plan_image.h"

namespace unlatch {

struct ListPlace {
  std::uint32_t offset, count;  // bytes from the beginning of the image; items
};

struct ImageHeader {
  char magic[8];
  std::uint32_t byte_order, version;
  std::uint64_t layout;    // get_image_layout()
  std::uint64_t bytes;     // of the whole image
  std::uint64_t checksum;  // calc_words_hash() of all behind it
  PlanNumbers numbers;
  ListPlace lists[kPlanLists];
};
static_assert(std::is_trivially_copyable_v<ImageHeader> && offsetof(ImageHeader, checksum) == 32);

inline constexpr char kImageMagic[8] = {'U', 'N', 'L', 'P', 'L', 'A', 'N', '\n'};
inline constexpr std::uint32_t kImageByteOrder = 0x01020304, kImageVersion = 1;
inline constexpr std::size_t kImageChecked = offsetof(ImageHeader, numbers);  // the checksum covers all from here on

// Sizes and alignments of all records: two builds with one layout read each other's images.
constexpr std::uint64_t get_image_layout() {
  std::uint64_t layout = 0xCBF29CE484222325ull;
  const auto add = [&](std::size_t number) { layout = (layout ^ number) * 0x100000001B3ull; };
  add(sizeof(ImageHeader));
  add(alignof(PlanNumbers));
  const PlanLists<CountedList> lists{};
  for_each_list(
      [&]<class T>(const CountedList<T>&) {
        static_assert(std::is_trivially_copyable_v<T> && alignof(T) <= kImageAlignment);
        add(sizeof(T));
        add(alignof(T));
      },
      lists);
  return layout;
}

// Makes `plan` a view of the image; on any status but kOk `plan` is of no use.
ImageStatus open_image(std::span<const std::byte> image, PlanData& plan) noexcept;

}  // namespace unlatch
