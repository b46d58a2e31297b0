#include "tools/import/urdf_text.h"

#include <algorithm>
#include <string_view>

#include "tools/import/imported.h"

namespace unlatch::tools {
namespace {

constexpr std::size_t kMostRemarks = 20;  // a file of another dialect has one at every element
constexpr std::string_view kBlank = " \t\r\n";

// Elements of a URDF that are read, and all of their attributes, between blanks (wiki.ros.org/urdf/XML).
constexpr std::pair<std::string_view, std::string_view> kAttributes[] = {
    {"robot", " name version xmlns "},
    {"link", " name type "},
    {"joint", " name type "},
    {"origin", " xyz rpy "},
    {"mass", " value "},
    {"inertia", " ixx ixy ixz iyy iyz izz "},
    {"inertial", " "},
    {"collision", " name "},
    {"visual", " name "},
    {"geometry", " "},
    {"box", " size "},
    {"cylinder", " radius length "},
    {"sphere", " radius "},
    {"mesh", " filename scale "},
    {"parent", " link "},
    {"child", " link "},
    {"axis", " xyz "},
    {"limit", " lower upper effort velocity "},
    {"dynamics", " damping friction "},
    {"mimic", " joint multiplier offset "},
    {"safety_controller", " soft_lower_limit soft_upper_limit k_position k_velocity "},
    {"calibration", " rising falling reference_position "}};
// Elements whose contents are for other programs, and have rules of their own.
constexpr std::string_view kForeign[] = {"gazebo", "transmission", "material", "sensor", "ros2_control"};

class Scanner {
 public:
  explicit Scanner(std::string_view text) : text_(text) {}

  UrdfText scan() {
    while (at_ < text_.size()) {
      const std::size_t begin = std::min(text_.find('<', at_), text_.size());
      advance(begin);
      if (at_ == text_.size()) break;
      if (starts("<!--"))
        advance_behind("-->");
      else if (starts("<![CDATA["))
        advance_behind("]]>");
      else if (starts("<?"))
        advance_behind("?>");
      else if (starts("</"))
        read_end();
      else
        read_element();
    }
    return std::move(found_);
  }

 private:
  [[nodiscard]] bool starts(std::string_view with) const { return text_.substr(at_).starts_with(with); }
  void advance(std::size_t to) {
    line_ += static_cast<int>(std::count(text_.begin() + static_cast<std::ptrdiff_t>(at_),
                                         text_.begin() + static_cast<std::ptrdiff_t>(to), '\n'));
    at_ = to;
  }
  void advance_behind(std::string_view end) {
    const std::size_t found = text_.find(end, at_);
    advance(found == std::string_view::npos ? text_.size() : found + end.size());
  }
  void skip(bool blanks) {
    const std::size_t end = blanks ? text_.find_first_not_of(kBlank, at_) : text_.find_first_of(" \t\r\n=/>", at_);
    advance(std::min(end, text_.size()));
  }
  std::string_view read_word() {
    const std::size_t begin = at_;
    skip(false);
    return text_.substr(begin, at_ - begin);
  }
  [[nodiscard]] std::string place() const { return "line " + std::to_string(line_) + ": "; }

  void read_end() {
    if (foreign_ > 0) --foreign_;
    advance_behind(">");
  }

  void read_element() {
    advance(at_ + 1);
    const std::string_view element = read_word();
    if (element.starts_with("xacro:"))
      throw ImportError(place() + "<" + std::string(element) +
                        "> is not expanded yet, and what it stands for would be missing: run xacro first");
    const bool is_foreign =
        foreign_ > 0 || std::find(std::begin(kForeign), std::end(kForeign), element) != std::end(kForeign);
    const auto* const known = std::find_if(std::begin(kAttributes), std::end(kAttributes),
                                           [&](const auto& entry) { return entry.first == element; });
    for (skip(true); at_ < text_.size() && text_[at_] != '>' && text_[at_] != '/'; skip(true)) {
      const std::size_t before = at_;
      read_attribute(std::string(element), known == std::end(kAttributes) || is_foreign ? "" : known->second);
      if (at_ == before) advance(at_ + 1);  // no XML, which urdfdom reports
    }
    const bool is_empty = at_ < text_.size() && text_[at_] == '/';
    if (is_foreign && !is_empty) ++foreign_;
    advance_behind(">");
  }

  // `known`: the element's attributes; "" if any is good.
  void read_attribute(const std::string& element, std::string_view known) {
    const std::string name(read_word());
    const int line = line_;
    skip(true);
    if (at_ == text_.size() || text_[at_] != '=') return;
    advance(at_ + 1);
    skip(true);
    if (at_ == text_.size() || (text_[at_] != '"' && text_[at_] != '\'')) return;
    const std::size_t begin = at_ + 1, end = std::min(text_.find(text_[at_], begin), text_.size());
    const std::string value(text_.substr(begin, end - begin));
    if (value.find("${") != std::string::npos || value.find("$(") != std::string::npos)
      throw ImportError(place() + name + "=\"" + value + "\" of <" + element +
                        "> is not expanded yet: run xacro first");
    if ((element == "link" || element == "joint") && name == "name" && foreign_ == 0)
      found_.lines.emplace(std::pair(element, value), line);
    if (!known.empty() && known.find(" " + name + " ") == std::string_view::npos && !name.starts_with("xmlns:")) {
      if (found_.remarks.size() < kMostRemarks)
        found_.remarks.push_back("line " + std::to_string(line) + ": the attribute '" + name + "' of <" + element +
                                 "> is unknown to URDF, and is not read");
      else if (found_.remarks.size() == kMostRemarks)
        found_.remarks.emplace_back("more unknown attributes follow");
    }
    advance(std::min(end + 1, text_.size()));
  }

  const std::string_view text_;
  std::size_t at_ = 0;
  int line_ = 1;
  int foreign_ = 0;  // depth inside an element for other programs
  UrdfText found_;
};

}  // namespace

UrdfText read_urdf_text(const std::string& text) { return Scanner(text).scan(); }

}  // namespace unlatch::tools
