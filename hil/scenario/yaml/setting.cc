#include "hil/scenario/yaml/setting.h"

#include <algorithm>
#include <charconv>
#include <utility>

#include "hil/scenario/yaml/yaml_override.h"

namespace unlatch::hil {
namespace {

bool is_plain(const std::string& text) {
  constexpr std::string_view kOthers = "_+-.*/()^ %";
  const auto is_safe = [&](char c) {
    return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
           kOthers.find(c) != std::string_view::npos;
  };
  const auto is_first = [](char c) {
    return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '(';
  };
  const bool negative = text.size() > 1 && text[0] == '-' && text[1] != ' ' && is_first(text[1]);
  return !text.empty() && (is_first(text[0]) || negative) && text.back() != ' ' &&
         std::all_of(text.begin(), text.end(), is_safe);
}

std::string quote(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    if (c == '\n')
      quoted += "\\n";
    else
      quoted += c;
  }
  return quoted + '"';
}

std::string write_flow(const YamlNode& node) {
  const auto write_scalar = [](const std::string& text) { return is_plain(text) ? text : quote(text); };
  std::string text;
  switch (node.kind) {
    case YamlNode::Kind::kNull:
      return "null";
    case YamlNode::Kind::kScalar:
      return write_scalar(node.text);
    case YamlNode::Kind::kSequence:
      for (const YamlNode& item : node.items) text += (text.empty() ? "" : ", ") + write_flow(item);
      return "[" + text + "]";
    case YamlNode::Kind::kMapping:
      for (std::size_t i = 0; i < node.items.size(); ++i)
        text += (i == 0 ? "" : ", ") + write_scalar(node.keys[i].text) + ": " + write_flow(node.items[i]);
      return "{" + text + "}";
  }
  return text;
}

void mark_all(YamlNode& node, const SourceMark& mark) {
  node.mark = mark;
  for (YamlKey& key : node.keys) key.mark = mark;
  for (YamlNode& item : node.items) mark_all(item, mark);
}

}  // namespace

std::string to_text(double value) {
  char text[32];
  const std::to_chars_result end = std::to_chars(text, text + sizeof text, value);
  return {text, end.ptr};
}

Setting make_setting(std::string path, double value, const std::string& unit) {
  return {std::move(path), make_scalar(to_text(value) + (unit.empty() ? "" : " " + unit))};
}

Setting make_setting(std::string path, std::span<const double> values) {
  Setting setting{std::move(path), {}};
  setting.value.kind = YamlNode::Kind::kSequence;
  for (const double value : values) setting.value.items.push_back(make_scalar(to_text(value)));
  return setting;
}

Setting parse_setting(const std::string& text) {
  auto [path, value] = split_override(text, 0);
  return {std::move(path), std::move(value)};
}

std::string to_text(const Setting& setting) { return setting.path + "=" + write_flow(setting.value); }

void apply_setting(const Setting& setting, int override_index, YamlNode& root) {
  const SourceMark mark{0, 0, override_index};
  YamlNode value = setting.value;
  mark_all(value, mark);
  replace_value(setting.path, mark, std::move(value), root);
}

}  // namespace unlatch::hil
