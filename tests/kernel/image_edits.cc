// image_edits [--edits N] [--seed S] FILE...: changes numbers of plan images where they stand, corrects the checksum,
// and opens what comes out: it is refused, or it flies a few ticks. Under a sanitizer a number that leads out of its
// list is seen. An image that ends the program is stored as ./image-finding.
#include <sys/time.h>

#include <algorithm>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <map>

#include "kernel/plan/plan_image.h"
#include "tests/support/image_file.h"
#include "tests/support/random.h"
#include "tests/support/simulation.h"
#include "unlatch/step.h"

namespace unlatch::test {
namespace {

constexpr long kHang_s = 20;                   // of the processor's time
constexpr std::size_t kMostBytes = 64u << 20;  // of a workspace: more is not flown
std::span<const std::byte> current;            // present image

// Uses only calls that a signal handler may make.
void keep_image(int signal) {
  std::FILE* const file = std::fopen("image-finding", "wb");
  if (file != nullptr) {
    std::fwrite(current.data(), 1, current.size(), file);
    std::fclose(file);
  }
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

// Ends the program after so much of the processor's time; 0: no longer.
void limit_time(long seconds) {
  const itimerval limit{{0, 0}, {seconds, 0}};
  setitimer(ITIMER_VIRTUAL, &limit, nullptr);
}

ImageHeader& get_header(std::span<std::byte> image) { return *reinterpret_cast<ImageHeader*>(image.data()); }

// Marks the lists of which the image has items.
void mark_lists(std::span<std::byte> image, bool* has_items) {
  for (std::size_t list = 0; list < kPlanLists; ++list)
    if (get_header(image).lists[list].count > 0) has_items[list] = true;
}

// A list of the image, or the header's numbers: its bytes.
std::span<std::byte> choose_part(std::span<std::byte> image, Random& random) {
  const PlanLists<CountedList> records{};
  std::size_t sizes[kPlanLists], count = 0;
  for_each_list([&]<class T>(const CountedList<T>&) { sizes[count++] = sizeof(T); }, records);
  const ImageHeader& header = get_header(image);
  for (;;) {
    const std::size_t chosen = static_cast<std::size_t>(random.below(static_cast<int>(kPlanLists) + 1));
    if (chosen == kPlanLists) return image.subspan(offsetof(ImageHeader, numbers), sizeof(PlanNumbers));
    const ListPlace& place = header.lists[chosen];
    if (place.count > 0) return image.subspan(place.offset, place.count * sizes[chosen]);
  }
}

template <class T>
T draw(Random& random) {
  constexpr T kOdd[] = {T(0),
                        T(1),
                        T(-1),
                        T(2),
                        T(3),
                        T(6),
                        T(7),
                        T(8),
                        T(64),
                        T(-2),
                        T(0x7f),
                        T(99),
                        T(255),
                        std::numeric_limits<T>::max(),
                        std::numeric_limits<T>::min()};
  return kOdd[random.below(static_cast<int>(std::size(kOdd)))];
}

template <class T>
void edit_integer(std::span<std::byte> part, Random& random) {
  const std::size_t count = part.size() / sizeof(T);
  if (count == 0) return;
  const auto draw_place = [&] {
    return part.data() + static_cast<std::size_t>(random.below(static_cast<int>(count))) * sizeof(T);
  };
  std::byte* const place = draw_place();
  T value;
  std::memcpy(&value, place, sizeof(T));
  switch (random.below(5)) {
    case 0:
      value = static_cast<T>(value ^ static_cast<T>(T{1} << random.below(8 * static_cast<int>(sizeof(T)) - 1)));
      break;
    case 1:
      value = draw<T>(random);
      break;
    case 2:
      value = static_cast<T>(static_cast<std::uint64_t>(value) + static_cast<std::uint64_t>(random.below(5)) - 2);
      break;
    case 3:
      value = static_cast<T>(random.below(64));
      break;
    default:  // another number of the same list
      std::memcpy(&value, draw_place(), sizeof(T));
  }
  std::memcpy(place, &value, sizeof(T));
}

void edit_number(std::span<std::byte> part, Random& random) {
  constexpr double kOdd[] = {
      0, -1, 1e-300, 1e300, -1e300, 1e9, HUGE_VAL, -HUGE_VAL, std::numeric_limits<double>::quiet_NaN()};
  const std::size_t count = part.size() / sizeof(double);
  if (count == 0) return;
  const double value = kOdd[random.below(static_cast<int>(std::size(kOdd)))];
  std::memcpy(part.data() + static_cast<std::size_t>(random.below(static_cast<int>(count))) * sizeof(double), &value,
              sizeof(value));
}

void edit(std::span<std::byte> image, Random& random) {
  const std::span<std::byte> part = choose_part(image, random);
  switch (random.below(8)) {
    case 0:
      return edit_number(part, random);
    case 1:
      return edit_integer<std::int8_t>(part, random);
    case 2: {  // a list is shorter
      ListPlace& place = get_header(image).lists[random.below(static_cast<int>(kPlanLists))];
      if (place.count > 0) place.count = static_cast<std::uint32_t>(random.below(static_cast<int>(place.count)));
      return;
    }
    default:
      return edit_integer<std::int32_t>(part, random);
  }
}

// Opens an image; flies it a few ticks if it is not refused. A word of what happened.
std::string fly(std::span<const std::byte> image) {
  constexpr int kTicks = 4;
  PlanMemory memory;
  const OpenedPlan opened = open_plan(image, memory);
  if (!opened.plan) return "refused";
  const Plan& plan = *opened.plan;
  if (plan.get_workspace_bytes() > kMostBytes || plan.get_state_bytes() > kMostBytes) return "too large";
  // Memory of exactly these sizes.
  const std::vector<char> none(std::max(plan.get_workspace_bytes(), plan.get_state_bytes()));
  const ImageMemory state_memory({none.data(), plan.get_state_bytes()}),
      workspace_memory({none.data(), plan.get_workspace_bytes()});
  State state(plan, state_memory.get());
  Workspace workspace(plan, workspace_memory.get());
  init_state(plan, state);
  const Inputs inputs{plan.get_initial_commands()};
  for (int i = 0; i < kTicks; ++i)
    if (step(plan, inputs, state, workspace).status != StepStatus::kOk) return "flown to an error";
  return "flown";
}

int run(int argc, char** argv) {
  std::vector<std::string> files;
  long edits = 0;
  std::uint64_t seed = 1;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--edits" && i + 1 < argc)
      edits = std::stol(argv[++i]);
    else if (word == "--seed" && i + 1 < argc)
      seed = std::stoull(argv[++i]);
    else
      files.push_back(word);
  }
  std::vector<std::vector<char>> images;
  bool has_items[kPlanLists] = {};
  for (const std::string& file : files) {
    images.push_back(read_image(file));
    const ImageMemory image(images.back());
    if (fly(image.get()) == "refused") throw std::runtime_error(file + ": refused as it is");
    mark_lists(image.get(), has_items);
  }
  if (images.empty()) throw std::runtime_error("no images");
  for (const int signal : {SIGABRT, SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGVTALRM}) std::signal(signal, keep_image);
  std::printf("seed %llu\n%td of %zu lists have items\n", static_cast<unsigned long long>(seed),
              std::count(std::begin(has_items), std::end(has_items), true), kPlanLists);
  std::fflush(stdout);
  Random random(seed);
  std::map<std::string, long> outcomes;
  for (long n = 0; n < edits; ++n) {
    const ImageMemory image(images[static_cast<std::size_t>(random.below(static_cast<int>(images.size())))]);
    for (int k = random.below(3); k >= 0; --k) edit(image.get(), random);
    ImageHeader& header = get_header(image.get());
    header.checksum = calc_words_hash(image.get().subspan(kImageChecked));
    current = image.get();
    limit_time(kHang_s);
    ++outcomes[fly(image.get())];
    limit_time(0);
  }
  for (const auto& [what, count] : outcomes) std::printf("%s: %ld\n", what.c_str(), count);
  return 0;
}

}  // namespace
}  // namespace unlatch::test

int main(int argc, char** argv) {
  try {
    return unlatch::test::run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
