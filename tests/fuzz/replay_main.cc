// Runs a fuzz target with any compiler: over the inputs in files and folders, then over random mutations of them.
//   fuzz_replay TARGET [--mutations N] [--seed S] FILE|FOLDER...
// An input that ends the program, or takes 10 s, is stored in the file that the last line names. clang's libFuzzer,
// which is guided by coverage, finds more (tools/fuzz); this program is for daily use, and for machines without clang.
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "tests/fuzz/replay.h"

namespace {

using Bytes = std::vector<std::uint8_t>;
using Random = std::mt19937_64;

constexpr unsigned kHang_s = 10;
constexpr std::size_t kMaxBytes = 8192;
const unlatch::fuzz::Target* target = nullptr;
const Bytes* current = nullptr;  // present input of the target

// Uses only calls that a signal handler may make: open and write.
void keep_input(int signal) {
  constexpr char kName[] = "fuzz-finding", kSaid[] = "FOUND: the input is in ./fuzz-finding\n";
  const int file = open(kName, O_WRONLY | O_CREAT | O_TRUNC, 0644);
  if (file >= 0 && current != nullptr) (void)!write(file, current->data(), current->size());
  (void)!write(STDERR_FILENO, kSaid, sizeof kSaid - 1);
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

void run(const Bytes& input) {
  current = &input;
  alarm(kHang_s);
  // Copy of exactly that size, so that a checker detects a read beyond its end.
  const Bytes copy(input);
  target->test_one_input(copy.data(), copy.size());
  alarm(0);
}

std::vector<Bytes> read_inputs(const std::vector<std::string>& names) {
  namespace fs = std::filesystem;
  std::vector<fs::path> files;
  for (const std::string& name : names) {
    if (fs::is_regular_file(name)) files.emplace_back(name);
    if (!fs::is_directory(name)) continue;
    for (const fs::directory_entry& entry : fs::directory_iterator(name)) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  std::vector<Bytes> inputs;
  for (const fs::path& file : files) {
    std::ifstream in(file, std::ios::binary);
    inputs.emplace_back(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
  }
  return inputs;
}

// Makes one small change.
void mutate(Bytes& bytes, const std::vector<Bytes>& inputs, Random& random) {
  constexpr std::uint8_t kOdd[] = {0, 1, 0x7f, 0x80, 0xff, '\n', ' ', ':', '-', '[', '{', '.', '0', '9', 'e', '"'};
  const auto below = [&random](std::size_t count) { return random() % count; };
  const Bytes& other = inputs[below(inputs.size())];
  const std::size_t at = below(bytes.size() + 1),
                    length = std::min<std::size_t>(below(below(32) + 1) + 1, bytes.size() - at);
  const auto here = bytes.begin() + static_cast<std::ptrdiff_t>(at), end = here + static_cast<std::ptrdiff_t>(length);
  switch (below(6)) {
    case 0:
      if (at < bytes.size()) *here = static_cast<std::uint8_t>(*here ^ (1u << below(8)));
      break;
    case 1:
      if (at < bytes.size()) *here = kOdd[below(sizeof kOdd)];
      break;
    case 2:
      bytes.erase(here, end);
      break;
    case 3:
      bytes.insert(here, kOdd[below(sizeof kOdd)]);
      break;
    case 4: {  // repetition
      const Bytes part(here, end);
      bytes.insert(here, part.begin(), part.end());
      break;
    }
    default:  // a piece of another input
      if (!other.empty()) {
        const std::size_t from = below(other.size()), most = std::min<std::size_t>(other.size() - from, below(256) + 1);
        const auto first = other.begin() + static_cast<std::ptrdiff_t>(from);
        if (at + most <= bytes.size() && below(2) == 0)
          std::copy_n(first, most, here);
        else
          bytes.insert(here, first, first + static_cast<std::ptrdiff_t>(most));
      }
  }
  if (bytes.size() > kMaxBytes) bytes.resize(kMaxBytes);
}

}  // namespace

int main(int count, char** arguments) {
  for (const unlatch::fuzz::Target& one : unlatch::fuzz::list_targets())
    if (count > 1 && std::strcmp(one.name, arguments[1]) == 0) target = &one;
  if (target == nullptr) {
    std::fprintf(stderr, "the first argument is a target:");
    for (const unlatch::fuzz::Target& one : unlatch::fuzz::list_targets()) std::fprintf(stderr, " %s", one.name);
    std::fprintf(stderr, "\n");
    return 2;
  }
  std::vector<std::string> names(arguments + 2, arguments + count);
  long mutations = 0;
  std::uint64_t seed = std::random_device{}();
  for (auto name = names.begin(); name != names.end();) {
    if (*name != "--mutations" && *name != "--seed") {
      ++name;
      continue;
    }
    if (name + 1 == names.end()) {
      std::fprintf(stderr, "%s wants a number\n", name->c_str());
      return 2;
    }
    if (*name == "--seed") seed = std::stoull(name[1]);
    if (*name == "--mutations") mutations = std::stol(name[1]);
    name = names.erase(name, name + 2);
  }
  for (const int signal : {SIGABRT, SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGALRM}) std::signal(signal, keep_input);

  const std::vector<Bytes> inputs = read_inputs(names);
  if (inputs.empty()) {
    std::fprintf(stderr, "no inputs\n");
    return 2;
  }
  for (const Bytes& input : inputs) run(input);
  std::printf("%zu inputs, no finding\n", inputs.size());
  if (mutations == 0) return 0;
  std::printf("seed %llu\n", static_cast<unsigned long long>(seed));
  std::fflush(stdout);
  Random random(seed);
  for (long i = 0; i < mutations; ++i) {
    Bytes bytes = inputs[random() % inputs.size()];
    for (std::uint64_t k = random() % 5 + 1; k > 0; --k) mutate(bytes, inputs, random);
    run(bytes);
  }
  std::printf("%ld mutations, no finding\n", mutations);
  return 0;
}
