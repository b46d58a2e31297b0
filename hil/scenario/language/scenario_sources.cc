#include "hil/scenario/language/scenario_sources.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "hil/scenario/text/count.h"
#include "hil/scenario/yaml/scenario_error.h"

namespace unlatch::hil {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxBytes = kMaxScenarioBytes, kMaxFiles = 64, kMaxName = 200;
const std::string kMarker = "--- # included: ";

// Finds the marker of an included file. YAML allows such a line only at the beginning of another document, which no
// scenario has.
std::size_t find_marker(const std::string& text, std::size_t from) {
  const std::size_t at = text.find("\n" + kMarker, from);
  return at == std::string::npos ? text.size() : at;
}

}  // namespace

bool is_standard_input(const std::string& path) { return path == "-" || path == "/dev/stdin"; }

// Reads a text file. A descriptor is read whatever its kind: standard input, or a shell's <(...). A named pipe or a
// device might never end.
std::string read_text_file(const std::string& path, const std::string& kind, std::size_t most) {
  const std::string mend = "name a readable " + (kind.ends_with(')') ? kind : kind + " file (.yaml)");
  const auto fail = [&](const std::string& what, const std::string& right) -> std::string {
    throw ScenarioError({{path, {}, "", what, right}});
  };
  const std::string source = path == "-" ? "/dev/stdin" : path;
  std::error_code error;
  const auto status = fs::status(source, error);
  if (status.type() == fs::file_type::not_found) return fail("there is no such file", mend);
  if (error) return fail("it cannot be read: " + error.message(), mend);
  if (status.type() == fs::file_type::directory) return fail("this is a folder", mend);
  const bool descriptor = source == "/dev/stdin" || source.starts_with("/dev/fd/");
  if (status.type() != fs::file_type::regular && !descriptor) return fail("this is not a regular file", mend);
  errno = 0;
  std::ifstream stream(source, std::ios::binary);
  if (!stream) {
    const int cause = errno;
    return fail(std::string("it cannot be opened: ") + (cause != 0 ? std::strerror(cause) : "unknown cause"), mend);
  }
  std::string text;
  constexpr std::size_t kPart = 1u << 20;
  while (stream && text.size() <= most) {
    const std::size_t before = text.size(), part = std::min(kPart, most + 1 - before);
    text.resize(before + part);
    stream.read(text.data() + before, static_cast<std::streamsize>(part));
    text.resize(before + static_cast<std::size_t>(stream.gcount()));
  }
  if (stream.bad()) return fail("it cannot be read", mend);
  if (text.size() > most) {
    const auto size = fs::file_size(source, error);
    const std::string limit = std::to_string(most >> 20) + " MiB";
    return fail("it has " + (error ? "" : count(size, "byte") + ", ") + "more than " + limit,
                "a " + kind + " file has at most " + std::to_string(most) + " bytes");
  }
  return text;
}

ScenarioSources::ScenarioSources(const std::string& text, std::string folder)
    : main_(text.substr(0, find_marker(text, 0) + 1)),
      folder_(std::move(folder)),
      joined_(find_marker(text, 0) < text.size()),
      bytes_(main_.size()) {
  std::size_t at = find_marker(text, 0);
  while (at < text.size()) {
    const std::size_t name = at + 1 + kMarker.size(), line = std::min(text.find('\n', name), text.size());
    at = find_marker(text, std::min(line, text.size()));
    const std::size_t begin = std::min(line + 1, text.size());
    texts_[text.substr(name, line - name)] = text.substr(begin, begin <= at ? at - begin : 0);
  }
}

const std::string& ScenarioSources::read(const std::string& name) {
  return read(name, {"scenario", kMaxBytes, [](const std::string& text) { return text; }});
}

const std::string& ScenarioSources::read_table(const std::string& name) {
  return read(name, {"table", kMaxTableBytes, [](const std::string& text) { return text; }, true});
}

const std::string& ScenarioSources::read(const std::string& name, const ConvertedFile& as) {
  if (order_.size() >= kMaxFiles) throw std::runtime_error("more than 64 files");
  auto found = texts_.find(name);
  if (found == texts_.end()) {
    if (joined_ || folder_.empty()) throw std::runtime_error("this text does not hold that file");
    std::error_code error;
    const fs::path folder = fs::canonical(folder_, error), path = fs::canonical(folder / name, error);
    if (error) throw std::runtime_error("there is no such file");
    if (std::mismatch(folder.begin(), folder.end(), path.begin(), path.end()).first != folder.end())
      throw std::runtime_error("it lies outside the scenario's folder");
    try {
      found = texts_.emplace(name, as.convert(read_text_file(path.string(), as.kind, as.most))).first;
    } catch (const ScenarioError& failure) {
      throw std::runtime_error(failure.mistakes.at(0).what);
    }
  }
  if (std::find(order_.begin(), order_.end(), name) != order_.end()) return found->second;
  order_.push_back(name);
  std::size_t& bytes = as.table ? table_bytes_ : bytes_;
  bytes += found->second.size();
  if (as.table && bytes > kMaxTableBytes)
    throw std::runtime_error("the files of tables together have more than 16 MiB");
  if (!as.table && bytes > kMaxBytes) throw std::runtime_error("scenario and included files have more than 1 MiB");
  return found->second;
}

std::string ScenarioSources::join() const {
  std::string text = main_;
  for (const std::string& name : order_) {
    if (text.empty() || text.back() != '\n') text += '\n';
    text += kMarker + name + "\n" + texts_.at(name);
  }
  return text;
}

std::string resolve_include(const std::string& from, const std::string& name) {
  const bool odd = std::any_of(name.begin(), name.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20; });
  if (name.empty() || name.size() > kMaxName || odd) throw std::runtime_error("this is not the name of a file");
  if (fs::path(name).is_absolute()) throw std::runtime_error("an absolute path");
  const fs::path path = (fs::path(from).parent_path() / name).lexically_normal();
  if (path.empty() || *path.begin() == "..") throw std::runtime_error("it lies outside the scenario's folder");
  return path.string();
}

}  // namespace unlatch::hil
