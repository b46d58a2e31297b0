// A dispersion study in C++: ten masses of the core, run by threads, and the requirement that comes nearest to its
// limit.
//   dispersion SCENARIO
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <string>

#include "unlatch.h"

namespace {

void check(unlatch_status status) {
  if (status < 0) throw std::runtime_error(unlatch_get_error(0)->text);
}

struct Close {
  void operator()(unlatch_batch* batch) const { unlatch_close_batch(batch); }
};

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: dispersion SCENARIO\n");
    return 2;
  }
  try {
    unlatch_options options{};
    options.size = sizeof options;
    options.flags = UNLATCH_JUDGE;
    unlatch_batch* handle = nullptr;
    check(unlatch_open_batch(argv[1], &options, &handle));
    const std::unique_ptr<unlatch_batch, Close> batch(handle);
    for (int i = 0; i < 10; ++i) {
      const std::string text = "bodies.core.mass=" + std::to_string(95 + i) + " t";
      const char* const override_text = text.c_str();
      check(unlatch_add_sample(handle, &override_text, 1));
    }
    check(unlatch_run_batch(handle, 0, 0));
    unlatch_array margins{};
    margins.size = sizeof margins;
    check(unlatch_get_batch_array(handle, UNLATCH_SAMPLE_MARGINS, &margins));
    for (std::size_t sample = 0; sample < margins.rows; ++sample) {
      std::size_t nearest = 0;
      for (std::size_t i = 1; i < margins.columns; ++i) {
        if (unlatch_get_number(&margins, sample, i) < unlatch_get_number(&margins, sample, nearest)) nearest = i;
      }
      unlatch_item item{};
      item.size = sizeof item;
      check(unlatch_describe_in_batch(handle, UNLATCH_REQUIREMENT, nearest, &item));
      std::printf("core of %zu t: %s has a margin of %.3f %s\n", 95 + sample, item.name,
                  unlatch_get_number(&margins, sample, nearest), item.unit);
    }
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
