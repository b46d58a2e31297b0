// Entries that templates made: their names differ only in numbers. Lists and drawings show many of them as one.
#pragma once

#include <cstddef>
#include <cstdio>
#include <string>
#include <vector>

namespace unlatch::tools {

// More alike entries than these are shown as one.
inline constexpr std::size_t kMostAlike = 6;

// plank7 is plank#, bolt12_3 is bolt#_#.
std::string without_numbers(const std::string& name);

// Indices of entries with the same key, in the order of the first of each; groups of at most kMostAlike are split into
// entries.
std::vector<std::vector<std::size_t>> group_alike(const std::vector<std::string>& keys);

// "plank1", or "plank1 … plank24 (24)".
std::string name_group(const std::vector<std::size_t>& group, const std::vector<std::string>& names);

// A list of entries with a text each. Those whose names and texts agree, but for numbers in names, are one entry.
class FoldedList {
 public:
  // Names within `text` are marked.
  void add(const std::string& name, const std::string& text);
  // Names in a column of `width` characters, then the texts.
  void print(std::FILE* to, int width) const;
  void print(std::FILE* to) const;  // each text directly behind its name
  static std::string mark(const std::string& name) { return '\1' + name + '\2'; }

 private:
  std::vector<std::string> keys_, names_, texts_;
};

}  // namespace unlatch::tools
