#include "hil/scenario/yaml/yaml_override.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <optional>

#include "hil/scenario/text/expression.h"
#include "hil/scenario/text/suggestion.h"
#include "hil/scenario/yaml/scenario_error.h"

namespace unlatch::hil {
namespace {

// Largest length of a list that an override creates.
constexpr std::size_t kMaxInsertedItems = 16;

std::optional<std::size_t> parse_index(const std::string& part) {
  std::size_t index = 0;
  const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), index);
  if (error != std::errc() || end != part.data() + part.size()) return std::nullopt;
  return index;
}

bool has_text(const YamlNode* node, std::string_view text) { return node && node->is_text(text); }

// Entry of a list of mappings that `part` names: `id`, `name` or `name:subject`; null if there is none.
const YamlNode* find_entry(const YamlNode& list, const std::string& part, const SourceMark& mark) {
  const std::size_t colon = part.find(':');
  const YamlNode* found = nullptr;
  for (const YamlNode& item : list.items) {
    const YamlNode* const id = item.find("id");
    if (!has_text(id ? id : item.find("name"), part.substr(0, colon))) continue;
    if (colon != std::string::npos && !has_text(item.find("subject"), part.substr(colon + 1))) continue;
    if (found) throw YamlError(mark, "several entries are called '" + part + "'", "write name:subject, or its number");
    found = &item;
  }
  return found;
}

YamlNode& find_named(YamlNode& list, const std::string& part, const SourceMark& mark) {
  const YamlNode* const found = find_entry(list, part, mark);
  if (!found) throw YamlError(mark, "no entry '" + part + "' in this list", "give a number from 0, or an entry's name");
  return const_cast<YamlNode&>(*found);  // a member of `list`
}

YamlNode& step_into_list(YamlNode& list, const std::string& part, const SourceMark& mark) {
  const auto index = parse_index(part);
  if (!index) return find_named(list, part, mark);
  if (list.sparse && *index < kMaxInsertedItems)
    while (list.items.size() <= *index) list.items.push_back({YamlNode::Kind::kNull, mark, "", {}, {}, false});
  if (*index >= list.items.size())
    throw YamlError(mark, "no entry [" + part + "]: the list has " + std::to_string(list.items.size()),
                    "entries count from 0");
  return list.items[*index];
}

std::string without_digits(std::string name) {
  std::erase_if(name, [](char c) { return c >= '0' && c <= '9'; });
  return name;
}

// Refuses a path that continues into an absent key whose name is close to an existing one into which it might: a
// misspelling, unless the two differ in a number (spring4 beside spring3).
void refuse_misspelt(const YamlNode& mapping, const std::string& part, const std::string& next,
                     const SourceMark& mark) {
  const auto continues = [&](const YamlNode& node) {
    return node.is_mapping() || (node.is_sequence() && (parse_index(next) || find_entry(node, next, mark) != nullptr));
  };
  std::vector<std::string> known;
  for (std::size_t i = 0; i < mapping.keys.size(); ++i)
    if (continues(mapping.items[i])) known.push_back(mapping.keys[i].text);
  const std::string* const nearest = find_nearest(part, known, part.size() < 6 ? 1 : 2);
  if (part.size() >= 4 && nearest && without_digits(*nearest) != without_digits(part))
    throw YamlError(mark, "there is no '" + part + "'",
                    "did you mean '" + *nearest + "'? To add one give it whole: " + part + "={key: value, ...}");
}

// Returns the child that `part` names; inserts a missing key, and creates a missing container.
YamlNode& step_into(YamlNode& node, const std::string& part, const SourceMark& mark) {
  if (node.kind == YamlNode::Kind::kNull) {
    node.sparse = parse_index(part).has_value();
    node.kind = node.sparse ? YamlNode::Kind::kSequence : YamlNode::Kind::kMapping;
    node.mark = mark;
  }
  if (node.is_sequence()) return step_into_list(node, part, mark);
  if (node.is_scalar())
    throw YamlError(mark, "'" + part + "' would be inside the single value '" + node.text + "'",
                    "shorten the path, or give the whole mapping: a={key: value}");
  if (YamlNode* child = node.find(part)) return *child;
  node.keys.push_back({part, mark, YamlKey::Origin::kAdded});
  node.items.push_back({YamlNode::Kind::kNull, mark, "", {}, {}, false});
  return node.items.back();
}

std::optional<Quantity> evaluate(const YamlNode& node, const Constants& constants) {
  if (!node.is_scalar()) return std::nullopt;
  try {
    return evaluate_expression(node.text, constants);
  } catch (const ExpressionError&) {  // the reader of the file reports it
    return std::nullopt;
  }
}

// Gives a plain number for a constant the SI unit of the value that it replaces, which expressions check. Its key is
// marked as replaced, unless the number stays the same.
void keep_unit(const std::string& name, YamlNode& root, YamlNode& value) {
  YamlNode* const section = root.find("constants");
  if (section == nullptr || !section->is_mapping()) return;
  Constants constants;
  for (std::size_t i = 0; i < section->keys.size(); ++i) {
    YamlKey& key = section->keys[i];
    const std::optional<Quantity> old = evaluate(section->items[i], constants);
    if (key.text != name) {
      if (old) constants[key.text] = *old;
      continue;
    }
    const std::optional<Quantity> given = evaluate(value, constants);
    if (old && given && given->dimension.is_plain() && !old->dimension.is_plain())
      value.text = "(" + value.text + ") " + describe_unit(old->dimension);
    if (key.origin == YamlKey::Origin::kFile && !(old && given && old->value == given->value))
      key.origin = YamlKey::Origin::kReplaced;
    return;
  }
}

bool is_of_name(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }

bool contains(const std::string& text, const std::string& name) {
  for (std::size_t at = text.find(name); at != std::string::npos; at = text.find(name, at + 1)) {
    const std::size_t end = at + name.size();
    if ((at == 0 || !is_of_name(text[at - 1])) && (end == text.size() || !is_of_name(text[end]))) return true;
  }
  return false;
}

// Keys whose texts are for readers, or say where a value is from: no use of what they name.
bool is_prose(const std::string& key) {
  static constexpr std::array kProse{"title", "text", "rationale", "parent", "source", "basis", "outputs"};
  return std::ranges::find(kProse, key) != kProse.end();
}

// Keys whose texts are names of things, which are no expressions; arguments of templates may be both.
bool is_name_of_thing(const std::string& key) {
  static constexpr std::array kNames{"id", "joint", "body", "relative_to"};
  return std::ranges::find(kNames, key) != kNames.end();
}

// True if a text names it, but for those within `except`. `arguments`: the node is within the use of a template.
bool names(const YamlNode& node, const std::string& name, const YamlNode& except, bool arguments = false) {
  if (&node == &except) return false;
  if (node.is_scalar()) return contains(node.text, name);
  for (std::size_t i = 0; i < node.items.size(); ++i) {
    const std::string key = node.is_mapping() ? node.keys[i].text : "";
    if (is_prose(key) || (!arguments && is_name_of_thing(key))) continue;
    if (names(node.items[i], name, except, arguments || key == "instances")) return true;
  }
  return false;
}

const YamlNode* find_section(const YamlNode& root, std::string_view name) {
  const YamlNode* const own = root.is_mapping() ? root.find(name) : nullptr;
  return own != nullptr && own->is_mapping() ? own : nullptr;
}

// Keys of a section that texts outside of it name, or values of such keys: what only an unread constant names is unread
// too.
std::vector<bool> list_read(const YamlNode& root, const YamlNode& section) {
  std::vector<bool> read(section.keys.size());
  std::vector<std::size_t> open;  // read, and their own values not looked at
  const auto mark = [&](std::size_t i) {
    if (!read[i]) open.push_back(i);
    read[i] = true;
  };
  for (std::size_t i = 0; i < read.size(); ++i)
    if (names(root, section.keys[i].text, section)) mark(i);
  while (!open.empty()) {
    const YamlNode& value = section.items[open.back()];
    open.pop_back();
    for (std::size_t i = 0; i < read.size(); ++i)
      if (!read[i] && names(value, section.keys[i].text, section)) mark(i);
  }
  return read;
}

// The constants, and the number of the one at a path; nothing for another path.
std::optional<std::pair<const YamlNode*, std::size_t>> find_constant(const YamlNode& root, const std::string& path) {
  constexpr std::string_view kSection = "constants.";
  const YamlNode* const own = find_section(root, "constants");
  if (own == nullptr || !path.starts_with(kSection)) return std::nullopt;
  for (std::size_t i = 0; i < own->keys.size(); ++i)
    if (own->keys[i].text == path.substr(kSection.size())) return std::pair(own, i);
  return std::nullopt;
}

constexpr std::array<std::pair<const char*, const char*>, 2> kReadSections{
    {{"constants", "constant"}, {"channels", "channel"}}};

}  // namespace

std::vector<YamlError> list_unread_overrides(const YamlNode& root) {
  std::vector<YamlError> unread;
  for (const auto& [section, noun] : kReadSections) {
    const YamlNode* const own = find_section(root, section);
    if (own == nullptr) continue;
    std::vector<std::string> known;
    for (const YamlKey& key : own->keys)
      if (key.origin != YamlKey::Origin::kAdded) known.push_back(key.text);
    if (std::ranges::all_of(own->keys, [](const YamlKey& key) { return key.origin == YamlKey::Origin::kFile; }))
      continue;
    // Most are named outside of the section; what reads the others is searched for once they are met.
    std::optional<std::vector<bool>> read;
    for (std::size_t i = 0; i < own->keys.size(); ++i) {
      const YamlKey& key = own->keys[i];
      if (key.origin == YamlKey::Origin::kFile || names(root, key.text, *own)) continue;
      if (!read) read = list_read(root, *own);
      if ((*read)[i]) continue;
      if (key.origin == YamlKey::Origin::kAdded)
        unread.emplace_back(key.mark,
                            "the scenario has no " + std::string(noun) + " '" + key.text + "', nor does it read one",
                            suggest(key.text, known));
      else
        unread.emplace_back(
            own->items[i].mark,
            "nothing reads the " + std::string(noun) + " '" + key.text + "': another value changes nothing",
            "use it in an expression, or leave it as it is");
    }
  }
  return unread;
}

void accept_read_overrides(YamlNode& root) {
  for (const auto& [name, noun] : kReadSections) {
    YamlNode* const own = root.is_mapping() ? root.find(name) : nullptr;
    if (own == nullptr || !own->is_mapping()) continue;
    if (std::ranges::all_of(own->keys, [](const YamlKey& key) { return key.origin == YamlKey::Origin::kFile; }))
      continue;
    const std::vector<bool> read = list_read(root, *own);
    for (std::size_t i = 0; i < read.size(); ++i)
      if (read[i]) own->keys[i].origin = YamlKey::Origin::kFile;
  }
}

std::vector<std::string> list_unread_constants(const YamlNode& root) {
  std::vector<std::string> unread;
  if (const YamlNode* const own = find_section(root, "constants")) {
    const std::vector<bool> read = list_read(root, *own);
    for (std::size_t i = 0; i < own->keys.size(); ++i)
      if (own->keys[i].mark.file == 0 && !read[i]) unread.push_back(own->keys[i].text);
  }
  return unread;
}

std::optional<WrittenUnit> find_constant_unit(const YamlNode& root, const std::string& path) {
  const auto place = find_constant(root, path);
  if (!place || !place->first->items[place->second].is_scalar()) return std::nullopt;
  const std::optional<WrittenUnit> unit = find_written_unit(place->first->items[place->second].text);
  return unit && unit->factor != 1 ? unit : std::nullopt;
}

bool is_unread_constant(const YamlNode& root, const std::string& path) {
  const auto place = find_constant(root, path);
  return place && !list_read(root, *place->first)[place->second];
}

std::vector<std::string> split_path(const std::string& path, const SourceMark& mark) {
  std::vector<std::string> parts;
  std::string part;
  const auto close = [&] {
    if (part.empty()) throw YamlError(mark, "an empty part in the path '" + path + "'", "write a.b[0]=value");
    parts.push_back(std::move(part));
    part.clear();
  };
  for (std::size_t i = 0; i < path.size(); ++i) {
    const char c = path[i];
    if (c == ']') {
      if (i + 1 < path.size() && path[i + 1] != '.' && path[i + 1] != '[')
        throw YamlError(mark, "text after ']' in the path '" + path + "'", "write a[0].b=value");
    } else if (c == '.' || c == '[') {
      close();
    } else {
      part += c;
    }
  }
  close();
  if (parts.size() > 16) throw YamlError(mark, "a path of more than 16 parts", "no scenario is that deep");
  return parts;
}

void replace_value(const std::string& path, const SourceMark& mark, YamlNode value, YamlNode& root) {
  const std::vector<std::string> parts = split_path(path, mark);
  for (const char* gone : {"include", "templates", "instances", "set"})
    if (parts[0] == gone)
      throw YamlError(mark, "'" + parts[0] + "' is worked out before values are replaced",
                      "name what it makes: bodies.booster1.mass");
  YamlNode* node = &root;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (node->kind == YamlNode::Kind::kMapping && i + 1 < parts.size() && !node->find(parts[i]))
      refuse_misspelt(*node, parts[i], parts[i + 1], mark);
    node = &step_into(*node, parts[i], mark);
  }
  if (parts.size() == 2 && parts[0] == "constants" && node->is_scalar()) keep_unit(parts[1], root, value);
  *node = std::move(value);
}

std::pair<std::string, YamlNode> split_override(const std::string& text, int override_index) {
  const SourceMark mark{0, 0, override_index};
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0)
    throw YamlError(mark, "no PATH=VALUE", "write for example bodies.core.mass=98000");
  YamlNode value = parse_yaml(text.substr(equals + 1), override_index);
  if (value.kind == YamlNode::Kind::kNull) throw YamlError(mark, "no value", "write for example step.dt=0.002");
  return {text.substr(0, equals), std::move(value)};
}

void apply_override(const std::string& text, int override_index, YamlNode& root) {
  auto [path, value] = split_override(text, override_index);
  replace_value(path, {0, 0, override_index}, std::move(value), root);
}

const YamlNode* find_value(const std::string& path, const SourceMark& mark, const YamlNode& root) {
  const YamlNode* node = &root;
  for (const std::string& part : split_path(path, mark)) {
    if (node->is_sequence()) {
      const auto index = parse_index(part);
      if (index && *index >= node->items.size()) return nullptr;
      node = index ? &node->items[*index] : find_entry(*node, part, mark);
    } else {
      node = node->find(part);
    }
    if (node == nullptr) return nullptr;
  }
  return node;
}

}  // namespace unlatch::hil
