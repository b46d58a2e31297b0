#include "tools/common/output.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "tools/common/unfinished_file.h"

namespace unlatch::tools {
namespace {

[[noreturn]] void fail(const std::string& target, const char* what, int error) {
  throw OutputError(target + ": cannot be " + what + ": " + std::strerror(error));
}

}  // namespace

void write_json(const nlohmann::ordered_json& json, const std::string& target) {
  if (target.empty()) return;
  write_text(json.dump(1) + "\n", target);
}

void write_text(const std::string& text, const std::string& target) {
  std::optional<UnfinishedFile> place;
  if (target != "-") place.emplace(target);
  std::FILE* const file = place ? std::fopen(place->path().c_str(), "wb") : stdout;
  if (file == nullptr) fail(target, "created", errno);
  errno = 0;
  bool written = std::fwrite(text.data(), 1, text.size(), file) == text.size() && std::fflush(file) == 0;
  int error = errno;
  const auto note_failure = [&] {
    written = false;
    error = errno;
  };
  if (place && std::fclose(file) != 0 && written) note_failure();
  if (written && place && !place->finish()) note_failure();
  if (!written) fail(target, "written", error);
}

void check_output(const std::string& target) {
  if (target.empty() || target == "-") return;
  std::error_code error;
  const auto type = std::filesystem::status(target, error).type();
  if (type == std::filesystem::file_type::directory) fail(target, "created", EISDIR);
  if (type != std::filesystem::file_type::regular && type != std::filesystem::file_type::not_found) return;
  const UnfinishedFile place(target);
  std::FILE* const file = std::fopen(place.path().c_str(), "ab");
  if (file == nullptr) fail(target, "created", errno);
  std::fclose(file);
}

JsonLines::JsonLines(const std::string& target) : target_(target) {
  if (target.empty()) return;
  file_.reset(target == "-" ? stdout : std::fopen(target.c_str(), "wb"));
  if (!file_) throw OutputError(target + ": cannot be created: " + std::strerror(errno));
}

void JsonLines::write(const std::string& json) {
  if (!file_) return;
  const std::string text = json + "\n";
  if (std::fwrite(text.data(), 1, text.size(), file_.get()) == text.size() && std::fflush(file_.get()) == 0) return;
  throw OutputError(target_ + ": cannot be written: " + std::strerror(errno));
}

}  // namespace unlatch::tools
