#include "hil/scenario/flexible/modes_file.h"

#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string_view>

#include "hil/scenario/text/count.h"
#include "hil/scenario/text/utf8.h"
#include "hil/scenario/yaml/yaml_reader.h"

namespace unlatch::hil {
namespace {

constexpr std::uintmax_t kMaxBytes = 256u << 20;
constexpr Eigen::Index kMaxModes = 200;
constexpr double kMaxPoints = 2e6;
constexpr std::size_t kMaxMistakes = 20;  // a shifted column would be wrong in every line

struct Word {
  std::string_view text;
  int column;
};

// Reads the lines that are neither empty nor a comment, and cuts them into words.
class Lines {
 public:
  explicit Lines(std::string_view text) : rest_(text) {}

  bool next() {
    while (!rest_.empty()) {
      const std::size_t end = std::min(rest_.find('\n'), rest_.size());
      line_ = rest_.substr(0, end);
      rest_.remove_prefix(std::min(end + 1, rest_.size()));
      ++number_;
      line_ = line_.substr(0, std::min(line_.find('#'), line_.size()));
      split();
      if (!words_.empty()) return true;
    }
    words_.clear();
    line_ = {};
    ++number_;
    return false;
  }

  const std::vector<Word>& words() const { return words_; }
  SourceMark mark(std::size_t word = 0) const {
    return {number_, word < words_.size() ? words_[word].column : static_cast<int>(line_.size()) + 1};
  }
  // Text after the first word.
  std::string tail() const {
    return words_.size() < 2 ? "" : std::string(words_[1].text.data(), words_.back().text.end());
  }

 private:
  void split() {
    constexpr std::string_view kBlank = " \t\r";
    words_.clear();
    for (std::size_t i = line_.find_first_not_of(kBlank); i < line_.size(); i = line_.find_first_not_of(kBlank, i)) {
      const std::size_t end = std::min(line_.find_first_of(kBlank, i), line_.size());
      words_.push_back({line_.substr(i, end - i), static_cast<int>(i) + 1});
      i = end;
    }
  }

  std::string_view rest_, line_;
  std::vector<Word> words_;
  int number_ = 0;
};

class Reader {
 public:
  Reader(std::string_view text, Mistakes& mistakes) : lines_(text), mistakes_(mistakes) {}

  Modes read() {
    if (!lines_.next() || lines_.words().size() != 3 || lines_.words()[0].text != "unlatch" ||
        lines_.words()[1].text != "modes" || lines_.words()[2].text != "1")
      stop(0, "this is not a modes file", "its first line is 'unlatch modes 1'");
    while (lines_.next()) {
      const std::string_view key = lines_.words()[0].text;
      if (key == "end") return finish();
      if (key == "title")
        modes_.title = lines_.tail();
      else if (key == "source")
        modes_.source.push_back(lines_.tail());
      else if (key == "frequencies")
        read_frequencies();
      else if (key == "marker")
        read_marker();
      else if (key == "points")
        read_points();
      else
        stop(0, quote_text(key) + " begins no section", "title, source, frequencies, marker, points or end");
    }
    stop(0, "the file ends too early", "a modes file ends in the line 'end'");
  }

 private:
  [[noreturn]] void stop(std::size_t word, const std::string& what, const std::string& mend) {
    mistakes_.add(lines_.mark(word), what, mend);
    mistakes_.throw_if_any();
    throw std::logic_error("a mistake was added");
  }
  void note(std::size_t word, const std::string& what, const std::string& mend) {
    mistakes_.add(lines_.mark(word), what, mend);
    if (mistakes_.count() >= kMaxMistakes) mistakes_.throw_if_any();
  }

  double number(std::size_t word) {
    std::string_view text = lines_.words()[word].text;
    if (text.starts_with('+')) text.remove_prefix(1);
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) {
      note(word, quote_text(text) + " is not a finite number", "write it like -1.25e-3");
      return 0;
    }
    return value;
  }
  // Numbers from word `first` to the end of the line, exactly `count`.
  std::vector<double> numbers(std::size_t first, Eigen::Index count, const std::string& what) {
    const auto wanted = static_cast<std::size_t>(count);
    const std::size_t there = lines_.words().size() - std::min(first, lines_.words().size());
    if (there != wanted)
      stop(first + std::min(there, wanted), hil::count(there, "number"),
           std::to_string(wanted) + " belong here: " + what);
    std::vector<double> values;
    for (std::size_t i = 0; i < wanted; ++i) values.push_back(number(first + i));
    return values;
  }
  void next_line(const std::string& what) {
    if (!lines_.next()) stop(0, "the file ends too early", what + " is missing");
  }
  void need_frequencies() {
    if (modes_.get_count() == 0) stop(0, "shapes before frequencies", "write the line 'frequencies …' first");
  }

  void read_frequencies() {
    if (modes_.get_count() > 0) stop(0, "frequencies for a second time", "write them once");
    const auto count = static_cast<Eigen::Index>(lines_.words().size()) - 1;
    if (count < 1 || count > kMaxModes)
      stop(0, hil::count(count, "frequency"), "1 to " + std::to_string(kMaxModes) + ", in Hz");
    modes_.frequencies_hz.resize(count);
    for (Eigen::Index k = 0; k < count; ++k) {
      const auto word = static_cast<std::size_t>(k) + 1;
      modes_.frequencies_hz[k] = number(word);
      if (modes_.frequencies_hz[k] < 0) note(word, "a negative frequency", "Hz, 0 for rigid-body modes");
    }
  }

  void read_marker() {
    need_frequencies();
    if (lines_.words().size() < 2) stop(1, "a marker without a name", "marker NAME x y z");
    ModalMarker marker;
    marker.name = lines_.words()[1].text;
    if (!is_name(marker.name))
      note(1, "'" + std::string(cut_text(marker.name, 40)) + "' is not a name", describe_name_rule(marker.name));
    for (const ModalMarker& other : modes_.markers)
      if (other.name == marker.name) note(1, "a second marker '" + marker.name + "'", "names are unique");
    const std::vector<double> p = numbers(2, 3, "marker NAME x y z");
    marker.position = {p[0], p[1], p[2]};
    marker.shape.resize(3, modes_.get_count());
    marker.rotation.resize(3, modes_.get_count());
    for (Eigen::Index k = 0; k < modes_.get_count(); ++k) {
      next_line("mode " + std::to_string(k + 1) + " of marker '" + marker.name + "'");
      const std::vector<double> v = numbers(0, 6, "displacement and rotation of mode " + std::to_string(k + 1));
      marker.shape.col(k) << v[0], v[1], v[2];
      marker.rotation.col(k) << v[3], v[4], v[5];
    }
    modes_.markers.push_back(std::move(marker));
  }

  void read_points() {
    need_frequencies();
    if (!modes_.points.empty()) stop(0, "points for a second time", "write them in one table");
    const double count = numbers(1, 1, "points NUMBER")[0];
    if (!(count >= 1 && count <= kMaxPoints) || count != std::floor(count))
      stop(1, "not a number of points", "a whole number from 1 to 2000000");
    const Eigen::Index modes = modes_.get_count();
    for (long i = 1; i <= static_cast<long>(count); ++i) {
      next_line("point " + std::to_string(i));
      const std::vector<double> v = numbers(0, 4 + 3 * modes, "mass x y z, then three for each mode");
      ModalPoint point{v[0], {v[1], v[2], v[3]}, Eigen::Matrix3Xd(3, modes)};
      if (point.mass < 0)
        note(0, "a negative mass", "lump so that every point's mass is 0 or more (HRZ, Gauss points)");
      for (Eigen::Index k = 0; k < 3 * modes; ++k) point.shape.data()[k] = v[static_cast<std::size_t>(4 + k)];
      modes_.points.push_back(std::move(point));
    }
  }

  Modes finish() {
    if (modes_.points.empty()) note(0, "no points", "a table 'points N' with the masses");
    mistakes_.throw_if_any();
    return std::move(modes_);
  }

  Lines lines_;
  Mistakes& mistakes_;
  Modes modes_;
};

void append(std::string& text, double value) {
  char digits[32];
  const auto [end, error] = std::to_chars(digits, digits + sizeof digits, value);
  text.append(digits, end);
}

template <typename Vector>
void append_all(std::string& text, const Vector& values) {
  for (Eigen::Index i = 0; i < values.size(); ++i) append(text += ' ', values[i]);
}

}  // namespace

Modes read_modes_text(const std::string& text, const std::string& file) {
  Mistakes mistakes(file, {});
  return Reader(text, mistakes).read();
}

Modes read_modes_file(const std::string& path) {
  const auto fail = [&](const std::string& what) -> std::string {
    throw ScenarioError({{path, {}, "", what, "name a readable modes file"}});
  };
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) fail("there is no such file");
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error || size > kMaxBytes) fail("it is larger than 256 MiB");
  std::ifstream stream(path, std::ios::binary);
  std::string text(static_cast<std::size_t>(size), '\0');
  if (!stream.read(text.data(), static_cast<std::streamsize>(text.size()))) fail("it cannot be read");
  return read_modes_text(text, path);
}

std::string write_modes_text(const Modes& modes) {
  std::string text = "unlatch modes 1\n";
  if (!modes.title.empty()) text += "title " + modes.title + "\n";
  for (const std::string& line : modes.source) text += "source " + line + "\n";
  text += "frequencies";
  append_all(text, modes.frequencies_hz);
  text += "\n";
  for (const ModalMarker& marker : modes.markers) {
    append_all(text += "marker " + marker.name, marker.position);
    text += "\n";
    for (Eigen::Index k = 0; k < modes.get_count(); ++k) {
      std::string line;
      append_all(line, marker.shape.col(k));
      append_all(line, marker.rotation.col(k));
      text += line.substr(1) + "\n";
    }
  }
  text += "points " + std::to_string(modes.points.size()) + "\n";
  for (const ModalPoint& point : modes.points) {
    append(text, point.mass);
    append_all(text, point.position);
    append_all(text, point.shape.reshaped());
    text += "\n";
  }
  return text + "end\n";
}

}  // namespace unlatch::hil
