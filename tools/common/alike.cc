#include "tools/common/alike.h"

#include <algorithm>
#include <map>

#include "tools/common/text.h"

namespace unlatch::tools {

std::string without_numbers(const std::string& name) {
  std::string out;
  for (const char c : name) {
    const bool digit = c >= '0' && c <= '9';
    if (!digit)
      out += c;
    else if (out.empty() || out.back() != '#')
      out += '#';
  }
  return out;
}

std::vector<std::vector<std::size_t>> group_alike(const std::vector<std::string>& keys) {
  std::map<std::string, std::vector<std::size_t>> alike;
  for (std::size_t i = 0; i < keys.size(); ++i) alike[keys[i]].push_back(i);
  std::vector<std::vector<std::size_t>> groups;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const std::vector<std::size_t>& group = alike[keys[i]];
    if (group.size() <= kMostAlike)
      groups.push_back({i});
    else if (group.front() == i)
      groups.push_back(group);
  }
  return groups;
}

std::string name_group(const std::vector<std::size_t>& group, const std::vector<std::string>& names) {
  const std::string& first = names[group.front()];
  if (group.size() == 1) return first;
  return first + " … " + names[group.back()] + " (" + std::to_string(group.size()) + ")";
}

namespace {

// `text` with its marked names changed by `change`.
template <typename Change>
std::string change_names(const std::string& text, const Change& change) {
  std::string out;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t open = text.find('\1', at), close = text.find('\2', at);
    if (open == std::string::npos || close == std::string::npos) return out + text.substr(at);
    out += text.substr(at, open - at) + change(text.substr(open + 1, close - open - 1));
    at = close + 1;
  }
  return out;
}

}  // namespace

void FoldedList::add(const std::string& name, const std::string& text) {
  keys_.push_back(without_numbers(name) + '\n' + change_names(text, without_numbers));
  names_.push_back(name);
  texts_.push_back(text);
}

void FoldedList::print(std::FILE* to, int width) const {
  for (const std::vector<std::size_t>& group : group_alike(keys_)) {
    const std::string name = name_group(group, names_), &text = texts_[group[0]];
    const std::string shown = group.size() > 1 ? change_names(text, without_numbers)
                                               : change_names(text, [](std::string own) { return own; });
    std::fprintf(to, "  %s%*s%s\n", name.c_str(),
                 std::max(0, width - static_cast<int>(count_characters(name))) + (width >= 0 ? 1 : 0), "",
                 shown.c_str());
  }
}

void FoldedList::print(std::FILE* to) const { print(to, -1); }

}  // namespace unlatch::tools
