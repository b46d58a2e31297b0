#include "hil/run/simulation/source_text.h"

#include <algorithm>

namespace unlatch::hil {

std::vector<SourceMessage> build_source(const std::string& text, const std::vector<std::string>& overrides,
                                        std::int64_t session) {
  std::string whole = text + '\0';
  for (const std::string& override : overrides) whole += override + '\0';
  std::vector<SourceMessage> messages((whole.size() + kSourcePerPart - 1) / kSourcePerPart);
  for (std::size_t i = 0; i < messages.size(); ++i) {
    const std::size_t begin = i * kSourcePerPart, count = std::min(kSourcePerPart, whole.size() - begin);
    messages[i].session = session;
    messages[i].part = static_cast<std::int32_t>(i);
    messages[i].parts = static_cast<std::int32_t>(messages.size());
    messages[i].count = static_cast<std::int32_t>(count);
    std::copy_n(whole.begin() + static_cast<std::ptrdiff_t>(begin), count, messages[i].bytes.begin());
  }
  return messages;
}

void SourceText::add(const SourceMessage& part) {
  if (parts_.empty()) {
    if (part.parts > kMaxParts) return;
    session_ = part.session;
    parts_.resize(static_cast<std::size_t>(part.parts));
    received_.resize(parts_.size());
    missing_ = parts_.size();
  }
  const auto index = static_cast<std::size_t>(part.part);
  const bool is_last = index + 1 == parts_.size();
  if (part.session != session_ || static_cast<std::size_t>(part.parts) != parts_.size() || index >= parts_.size() ||
      received_[index] || (!is_last && static_cast<std::size_t>(part.count) != kSourcePerPart)) {
    return;
  }
  parts_[index].assign(part.bytes.begin(), part.bytes.begin() + part.count);
  received_[index] = true;
  --missing_;
}

std::vector<std::string> SourceText::split() const {
  std::string whole;
  for (const std::string& part : parts_) whole += part;
  std::vector<std::string> texts;
  for (std::size_t begin = 0; begin < whole.size();) {
    const std::size_t end = whole.find('\0', begin);
    if (end == std::string::npos) return {};
    texts.push_back(whole.substr(begin, end - begin));
    begin = end + 1;
  }
  return texts;
}

}  // namespace unlatch::hil
