// Plan images: refused with a status, or every list of the plan lies in the image.
#include <cstring>
#include <vector>

#include "kernel/plan/plan_image.h"
#include "tests/fuzz/fuzz.h"

using namespace unlatch;

namespace {

// Memory that ends where the image does, so that sanitizers see what is read behind it.
class Aligned {
 public:
  explicit Aligned(std::span<const std::uint8_t> bytes) : size_(bytes.size()) {
    memory_ = static_cast<std::byte*>(::operator new (size_, std::align_val_t{kImageAlignment}));
    if (size_ > 0) std::memcpy(memory_, bytes.data(), size_);
  }
  ~Aligned() { ::operator delete (memory_, std::align_val_t{kImageAlignment}); }
  Aligned(const Aligned&) = delete;
  Aligned& operator=(const Aligned&) = delete;
  [[nodiscard]] std::span<std::byte> get() const { return {memory_, size_}; }

 private:
  std::byte* memory_;
  std::size_t size_;
};

void open(std::span<const std::byte> image) {
  PlanMemory memory;
  const OpenedPlan opened = open_plan(image, memory);
  fuzz::require(opened.plan.has_value() == (opened.status == ImageStatus::kOk), "a plan and its status disagree");
  fuzz::require(get_status_text(opened.status)[0] != 0, "a status without text");
  if (!opened.plan) return;
  PlanLists<FixedList> lists = get_data(*opened.plan);
  for_each_list(
      [&](const auto& list) {
        const std::span<const std::byte> bytes = std::as_bytes(list);
        fuzz::require(bytes.empty() ||
                          (bytes.data() >= image.data() && bytes.data() + bytes.size() <= image.data() + image.size()),
                      "a list outside of its image");
      },
      lists);
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const Aligned image({data, size});
  open(image.get());
  if (size < sizeof(ImageHeader)) return 0;
  // Again with a right checksum, so that what lies behind it is reached.
  auto& header = *reinterpret_cast<ImageHeader*>(image.get().data());
  header.checksum = calc_words_hash(image.get().first(size / 8 * 8).subspan(kImageChecked));
  header.bytes = size / 8 * 8;
  header.layout = get_image_layout();
  open(image.get());
  return 0;
}
