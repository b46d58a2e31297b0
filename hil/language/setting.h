// A value at a path that `--set` reaches, as a program gives it: to the last bit what the text PATH=VALUE gives.
#pragma once

#include <span>
#include <string>

#include "hil/language/yaml_document.h"

namespace unlatch::hil {

struct Setting {
  std::string path;
  YamlNode value;
};

// A number in `unit`, an SI unit as describe_unit() gives it; "": the unit of what stands there. The bits of the value
// are the same. Three or more numbers as a list.
Setting make_setting(std::string path, double value, const std::string& unit = "");
Setting make_setting(std::string path, std::span<const double> values);
// PATH=VALUE, as `--set` takes it. Throws YamlError.
Setting parse_setting(const std::string& text);

// PATH=VALUE that parse_setting() reads as the same.
std::string to_text(const Setting& setting);
// The shortest text that reads as the same double.
std::string to_text(double value);

// Puts the value into a tree, with `override_index` as its place. Throws YamlError.
void apply_setting(const Setting& setting, int override_index, YamlNode& root);

}  // namespace unlatch::hil
