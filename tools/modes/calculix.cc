#include "tools/modes/calculix.h"

#include <charconv>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <string_view>

#include "hil/scenario/text/count.h"

namespace unlatch::tools {
namespace {

// Lines of a file, with fields by column (from 1, as its format is described).
class Columns {
 public:
  Columns(std::string_view text, std::string name) : rest_(text), name_(std::move(name)) {}

  bool next() {
    if (rest_.empty()) return false;
    const std::size_t end = std::min(rest_.find('\n'), rest_.size());
    line_ = rest_.substr(0, end);
    rest_.remove_prefix(std::min(end + 1, rest_.size()));
    ++number_;
    return true;
  }
  void next_or_fail(const char* what) {
    if (!next()) fail(std::string("the file ends before ") + what);
  }
  bool starts_with(std::string_view head) const { return line_.starts_with(head); }
  std::string_view line() const { return line_; }

  double number(std::size_t first, std::size_t width) const {
    const std::string_view field = get_field(first, width);
    double value = 0;
    const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
    if (error != std::errc() || end != field.data() + field.size() || !std::isfinite(value))
      fail("columns " + std::to_string(first) + " to " + std::to_string(first + width - 1) + " hold '" +
           std::string(field) + "', where a number belongs");
    return value;
  }
  int integer(std::size_t first, std::size_t width) const {
    const std::string_view field = get_field(first, width);
    int value = 0;
    const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
    if (error != std::errc() || end != field.data() + field.size())
      fail("columns " + std::to_string(first) + " to " + std::to_string(first + width - 1) + " hold '" +
           std::string(field) + "', where a whole number belongs");
    return value;
  }
  [[noreturn]] void fail(const std::string& what) const {
    throw CalculixError(name_ + ":" + std::to_string(number_) + ": " + what);
  }

 private:
  // Without the blanks around it.
  std::string_view get_field(std::size_t first, std::size_t width) const {
    std::string_view field = first <= line_.size() ? line_.substr(first - 1, width) : std::string_view();
    const std::size_t begin = std::min(field.find_first_not_of(' '), field.size());
    field.remove_prefix(begin);
    return field.substr(0, field.find_last_not_of(" \r") + 1);
  }

  std::string_view rest_, line_;
  std::string name_;
  int number_ = 0;
};

std::size_t count_nodes(ElementType type) {
  switch (type) {
    case ElementType::kTriangle3:
      return 3;
    case ElementType::kTriangle6:
      return 6;
    case ElementType::kQuad4:
      return 4;
    case ElementType::kQuad8:
      return 8;
  }
  return 0;
}

// A .frd file: blocks "2C" (nodes), "3C" (elements), "100C" (a field of a mode), each closed by a line " -3".
class FrdReader {
 public:
  FrdReader(std::string_view text, const std::string& name) : in_(text, name) {}

  MeshModes read() {
    bool ended = false;
    while (in_.next()) {
      if (in_.starts_with("    1UPGM"))
        modes_.program = trim(in_.line().substr(9)) + modes_.program;
      else if (in_.starts_with("    1UVERSION"))
        modes_.program += " " + trim(in_.line().substr(13));
      else if (in_.starts_with("    2C"))
        read_nodes();
      else if (in_.starts_with("    3C"))
        read_elements();
      else if (in_.starts_with("  100C"))
        read_field();
      else if (in_.starts_with(" 9999"))
        ended = true;
    }
    if (!ended) in_.fail("the file ends without its last line, 9999: CalculiX has not finished writing it");
    if (modes_.mesh.elements.empty()) in_.fail("it has no elements");
    if (modes_.displacements.empty()) in_.fail("it has no mode shapes (a *FREQUENCY step with *NODE FILE and U)");
    return std::move(modes_);
  }

 private:
  static std::string trim(std::string_view text) {
    const std::size_t begin = std::min(text.find_first_not_of(' '), text.size());
    return std::string(text.substr(begin, text.find_last_not_of(" \r") + 1 - begin));
  }
  void check_format() {
    if (in_.line().size() < 74 || in_.line()[73] != '1') in_.fail("not the ASCII format 1 of .frd files");
  }
  void read_nodes() {
    check_format();
    if (!modes_.displacements.empty()) in_.fail("nodes behind a mode shape");
    for (in_.next_or_fail("its nodes"); in_.starts_with(" -1"); in_.next_or_fail("the end of its nodes")) {
      const int id = in_.integer(4, 10);
      if (!index_.emplace(id, static_cast<int>(modes_.mesh.nodes.size())).second)
        in_.fail("node " + std::to_string(id) + " for a second time");
      modes_.mesh.nodes.emplace_back(in_.number(14, 12), in_.number(26, 12), in_.number(38, 12));
    }
  }
  int get_index(int id) {
    const auto found = index_.find(id);
    if (found == index_.end()) in_.fail("there is no node " + std::to_string(id));
    return found->second;
  }
  void read_elements() {
    check_format();
    for (in_.next_or_fail("its elements"); in_.starts_with(" -1"); in_.next_or_fail("the end of its elements")) {
      Element element;
      const int type = in_.integer(14, 5);
      if (type < 7 || type > 10)
        in_.fail("an element of type " + std::to_string(type) +
                 "; shells (types 7 to 10) are read. Write shells with *NODE FILE, OUTPUT=2D; for anything else use "
                 "the neutral modes file");
      element.type = static_cast<ElementType>(type);
      in_.next_or_fail("the nodes of an element");
      for (std::size_t k = 0; k < count_nodes(element.type); ++k)
        element.nodes.push_back(get_index(in_.integer(4 + 10 * k, 10)));
      modes_.mesh.elements.push_back(element);
    }
  }
  void read_field() {
    const double frequency_hz = in_.number(13, 12);
    in_.next_or_fail("a result");
    if (!in_.starts_with(" -4  DISP")) return;
    while (in_.starts_with(" -4") || in_.starts_with(" -5")) in_.next_or_fail("a mode shape");
    std::vector<Eigen::Vector3d> shape(modes_.mesh.nodes.size(), Eigen::Vector3d::Zero());
    std::set<int> found;
    for (; in_.starts_with(" -1"); in_.next_or_fail("the end of a mode shape")) {
      const int node = get_index(in_.integer(4, 10));
      if (!found.insert(node).second) in_.fail("a node for a second time");
      shape[static_cast<std::size_t>(node)] = {in_.number(14, 12), in_.number(26, 12), in_.number(38, 12)};
    }
    if (found.empty() || found.size() != shape.size())
      in_.fail("a mode shape at " + std::to_string(found.size()) + " of " + hil::count(shape.size(), "node"));
    modes_.frequencies_hz.push_back(frequency_hz);
    modes_.displacements.push_back(std::move(shape));
  }

  Columns in_;
  MeshModes modes_;
  std::map<int, int> index_;  // node numbers to indices
};

std::string read_file(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw CalculixError(path + ": it cannot be opened");
  std::string text{std::istreambuf_iterator<char>(stream), {}};
  if (stream.bad() || text.empty()) throw CalculixError(path + ": it cannot be read, or is empty");
  return text;
}

}  // namespace

std::string write_deck(const Mesh& mesh, const HalfShell& shell, int modes) {
  std::string deck = "*NODE\n";
  char line[200];
  for (std::size_t i = 0; i < mesh.nodes.size(); ++i) {
    const Eigen::Vector3d& p = mesh.nodes[i];
    std::snprintf(line, sizeof line, "%zu, %.12g, %.12g, %.12g\n", i + 1, p.x(), p.y(), p.z());
    deck += line;
  }
  deck += "*ELEMENT, TYPE=S8R, ELSET=SHELL\n";
  for (std::size_t i = 0; i < mesh.elements.size(); ++i) {
    deck += std::to_string(i + 1);
    for (const int node : mesh.elements[i].nodes) deck += ", " + std::to_string(node + 1);
    deck += "\n";
  }
  std::snprintf(line, sizeof line,
                "*MATERIAL, NAME=ISOTROPIC\n*ELASTIC\n%.12g, %.12g\n*DENSITY\n%.12g\n"
                "*SHELL SECTION, ELSET=SHELL, MATERIAL=ISOTROPIC\n%.12g\n",
                shell.young, shell.poisson, shell.density, shell.thickness);
  deck += line;
  return deck + "*STEP\n*FREQUENCY\n" + std::to_string(modes) + "\n*NODE FILE, OUTPUT=2D\nU\n*END STEP\n";
}

MeshModes parse_frd(const std::string& text, const std::string& name) { return FrdReader(text, name).read(); }

std::vector<double> parse_dat(const std::string& text, const std::string& name) {
  Columns in(text, name);
  while (in.next())
    if (in.line().find("E I G E N V A L U E   O U T P U T") != std::string_view::npos) break;
  std::vector<double> frequencies_hz;
  while (in.next()) {
    if (in.line().find("P A R T I C I P A T I O N") != std::string_view::npos) break;
    const bool is_row =
        in.line().size() >= 71 && in.line().substr(0, 7).find_first_of("0123456789") != std::string_view::npos;
    if (!is_row) continue;
    if (in.integer(1, 7) != static_cast<int>(frequencies_hz.size()) + 1) in.fail("modes out of order");
    const double hz = in.number(40, 16);
    if (hz < 0) in.fail("a negative frequency");
    frequencies_hz.push_back(hz);
  }
  if (frequencies_hz.empty()) throw CalculixError(name + ": it has no table of eigenvalues");
  return frequencies_hz;
}

MeshModes read_calculix(const std::string& frd, const std::string& dat) {
  MeshModes modes = parse_frd(read_file(frd), frd);
  if (dat.empty()) return modes;
  const std::vector<double> frequencies_hz = parse_dat(read_file(dat), dat);
  constexpr double kSame = 1e-4;  // .frd files have six digits
  constexpr double kRigid = 0.1;  // Hz; below it both are noise
  if (frequencies_hz.size() != modes.frequencies_hz.size())
    throw CalculixError(dat + ": " + hil::count(frequencies_hz.size(), "mode") + ", where " + frd + " has " +
                        std::to_string(modes.frequencies_hz.size()));
  for (std::size_t k = 0; k < frequencies_hz.size(); ++k)
    if (frequencies_hz[k] > kRigid && std::abs(frequencies_hz[k] - modes.frequencies_hz[k]) > kSame * frequencies_hz[k])
      throw CalculixError(dat + ": mode " + std::to_string(k + 1) + " has another frequency than in " + frd +
                          ": they are not of one run");
  modes.frequencies_hz = frequencies_hz;
  return modes;
}

}  // namespace unlatch::tools
