// Results for programs and people: whole files, standard output, JSON lines.
#pragma once

#include <cstdio>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <stdexcept>
#include <string>

namespace unlatch::tools {

// Destination of --json: none, standard output ("-"), or a file. Throws OutputError.
class OutputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};
void write_json(const nlohmann::ordered_json& json, const std::string& target);
void write_text(const std::string& text, const std::string& target);  // whole, or the file stays as it was
// The same error before the work rather than after it: a target that cannot be created. Leaves no file.
void check_output(const std::string& target);

// The same for results that come one after another, one object a line, each out at once. Nowhere: nothing is written.
class JsonLines {
 public:
  explicit JsonLines(const std::string& target);
  void write(const std::string& json);  // an object in one line

 private:
  struct Close {
    void operator()(std::FILE* file) const {
      if (file != stdout) std::fclose(file);
    }
  };
  const std::string target_;
  std::unique_ptr<std::FILE, Close> file_;
};
// People's text goes to standard error when standard output is JSON's.
inline std::FILE* get_people_stream(const std::string& json_target) { return json_target == "-" ? stderr : stdout; }

}  // namespace unlatch::tools
