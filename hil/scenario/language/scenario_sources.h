// The text of a scenario and of the files that it includes: from a folder, or from one text that contains them all, as
// in recordings. In such a text each included file follows a line `--- # included: NAME`.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

namespace unlatch::hil {

// Returns true for "-" and "/dev/stdin": standard input.
bool is_standard_input(const std::string& path);
inline constexpr std::size_t kMaxScenarioBytes = 1u << 20;
// Of the files of its tables, all together: a table of 100,000 entries over three axes has some three million bytes.
inline constexpr std::size_t kMaxTableBytes = 16u << 20;
// Reads a regular file, or an open descriptor, of at most `most` bytes; `kind`: the expected kind of file, for
// messages. Throws ScenarioError.
std::string read_text_file(const std::string& path, const std::string& kind, std::size_t most = kMaxScenarioBytes);

// Conversion of a file's bytes into the text that is kept: for meshes.
struct ConvertedFile {
  std::string kind;                                              // for messages
  std::size_t most = 0;                                          // bytes
  std::function<std::string(const std::string& bytes)> convert;  // may throw std::runtime_error
  bool table = false;  // counts towards kMaxTableBytes, not towards the scenario's bytes
};

class ScenarioSources {
 public:
  // `folder` may be empty: then no file is read from the disk.
  ScenarioSources(const std::string& text, std::string folder);

  const std::string& main() const { return main_; }
  // Text of an included file, or of a file of modes, by its path from the scenario's folder. Throws std::runtime_error
  // if there is none, if it lies outside that folder (symbolic links followed), or if the texts together have more than
  // kMaxScenarioBytes.
  const std::string& read(const std::string& name);
  // Text of a file of tables; all of them together have at most kMaxTableBytes.
  const std::string& read_table(const std::string& name);
  // Text that is made from a file.
  const std::string& read(const std::string& name, const ConvertedFile& as);
  // Main text with all texts that were read.
  std::string join() const;

 private:
  std::string main_, folder_;
  bool joined_ = false;                       // the text contains its included files
  std::map<std::string, std::string> texts_;  // included texts, by name
  std::vector<std::string> order_;            // names, in the order of reading
  std::size_t bytes_ = 0, table_bytes_ = 0;
};

// Path, from the scenario's folder, of a file that `from` (a path from that folder) includes as `name`. Throws
// std::runtime_error for absolute paths and for those that lead out of the folder.
std::string resolve_include(const std::string& from, const std::string& name);

}  // namespace unlatch::hil
