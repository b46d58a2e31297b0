// The text of a URDF beside urdfdom, which ignores what it does not know: elements, attributes and their lines.
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

namespace unlatch::tools {

struct UrdfText {
  std::map<std::pair<std::string, std::string>, int> lines;  // of the first ("link" or "joint", name), from 1
  std::vector<std::string> remarks;                          // unknown attributes, each with its line
};

// Throws ImportError for a text that xacro has not expanded yet.
UrdfText read_urdf_text(const std::string& text);

}  // namespace unlatch::tools
