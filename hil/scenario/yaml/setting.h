// A value at a path that `--set` reaches, as a program gives it; the result has the bits of the text PATH=VALUE.
#pragma once

#include <span>
#include <string>

#include "hil/scenario/yaml/yaml_document.h"

namespace unlatch::hil {

struct Setting {
  std::string path;
  YamlNode value;
};

// Makes a setting from a number in `unit`, an SI unit as describe_unit() gives it; "": the unit of the value in the
// file. Keeps the bits of the value. Three or more numbers make a list.
Setting make_setting(std::string path, double value, const std::string& unit = "");
Setting make_setting(std::string path, std::span<const double> values);
// Parses PATH=VALUE, as `--set` takes it. Throws YamlError.
Setting parse_setting(const std::string& text);

// Text PATH=VALUE that parse_setting() reads as the same.
std::string to_text(const Setting& setting);
// Shortest text that reads as the same double.
std::string to_text(double value);

// Sets the value in a tree, with `override_index` as its place. Throws YamlError.
void apply_setting(const Setting& setting, int override_index, YamlNode& root);

}  // namespace unlatch::hil
