// Templates: entries that are written once and repeated for several rows of parameters. `<name>` in a key or a value of
// a template stands for a parameter: alone it is replaced by the whole value of any kind, inside a longer text by its
// text. YAML needs no quotes for the angle brackets.
#include <algorithm>
#include <cmath>

#include "hil/scenario/language/bounded_number.h"
#include "hil/scenario/language/scenario_parts.h"
#include "hil/scenario/text/suggestion.h"
#include "hil/scenario/yaml/yaml_reader.h"

namespace unlatch::hil {
namespace {

constexpr std::size_t kMaxNodes = 200'000;  // nodes of all instances together
constexpr std::size_t kMaxDepth = 32, kMaxText = 1024;

struct Binding {
  std::string name;
  YamlNode value;
};
using Bindings = std::vector<Binding>;

const std::string kCounter = "i";  // the parameter of `count`

const Binding* find_binding(const Bindings& bindings, std::string_view name) {
  const auto at = std::find_if(bindings.begin(), bindings.end(), [&](const Binding& b) { return b.name == name; });
  return at == bindings.end() ? nullptr : &*at;
}

// Text inserted into a longer text: a number or a name as it is; `1 + 2` and `-3` get parentheses to keep their
// meaning.
std::string get_inserted_text(const std::string& text) {
  const bool plain = std::all_of(text.begin(), text.end(), [](char c) {
    return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || c == '.';
  });
  return plain || is_name(text) ? text : "(" + text + ")";
}

struct Size {
  std::size_t nodes = 1, depth = 1;
};

Size measure(const YamlNode& node) {
  Size size;
  for (const YamlNode& item : node.items) {
    const Size inner = measure(item);
    size.nodes += inner.nodes;
    size.depth = std::max(size.depth, inner.depth + 1);
  }
  return size;
}

// Copies nodes and inserts parameters. Parameters of parameters could grow without end: beyond the bounds no more nodes
// are made, and `nodes` shows it.
class Substitution {
 public:
  Substitution(const Bindings& bindings, int instance, std::size_t& nodes, Mistakes& mistakes)
      : bindings_(bindings), instance_(instance), nodes_(nodes), mistakes_(mistakes) {}

  YamlNode copy(const YamlNode& node, std::size_t depth = 1) {
    if (++nodes_ > kMaxNodes) return {};
    if (node.is_scalar()) return copy_scalar(node, depth);
    YamlNode made;
    made.kind = node.kind;
    made.mark = place(node.mark);
    for (const YamlKey& key : node.keys) made.keys.push_back({insert(key.text, key.mark), place(key.mark)});
    for (const YamlNode& item : node.items) made.items.push_back(copy(item, depth + 1));
    return made;
  }

 private:
  SourceMark place(SourceMark mark) const {
    if (instance_ >= 0) mark.instance = instance_;
    return mark;
  }

  YamlNode copy_scalar(const YamlNode& node, std::size_t depth) {
    const bool whole = node.text.size() > 2 && node.text.front() == '<' && node.text.back() == '>';
    const Binding* binding = whole ? find_binding(bindings_, node.text.substr(1, node.text.size() - 2)) : nullptr;
    if (binding != nullptr) {
      const Size size = measure(binding->value);
      nodes_ += depth + size.depth > kMaxDepth ? kMaxNodes : size.nodes;
      return nodes_ > kMaxNodes ? YamlNode{} : binding->value;
    }
    YamlNode made = node;
    made.mark = place(node.mark);
    made.text = insert(node.text, made.mark);
    return made;
  }

  std::string insert(const std::string& text, const SourceMark& mark) {
    std::string made;
    for (std::size_t at = 0; at < text.size();) {
      const std::size_t open = text.find('<', at), close = text.find('>', open);
      if (open == std::string::npos || close == std::string::npos) return made + text.substr(at);
      const std::string name = text.substr(open + 1, close - open - 1);
      made += text.substr(at, open - at);
      made += is_name(name) ? get_value(name, mark) : text.substr(open, close + 1 - open);
      if (made.size() > kMaxText) {
        mistakes_.add(place(mark), "parameters make a text of more than 1024 bytes", "give them shorter values");
        return "0";
      }
      at = close + 1;
    }
    return made;
  }

  std::string get_value(const std::string& name, const SourceMark& mark) {
    const Binding* binding = find_binding(bindings_, name);
    if (binding && binding->value.is_scalar()) return get_inserted_text(binding->value.text);
    std::vector<std::string> known;
    for (const Binding& other : bindings_) known.push_back(other.name);
    if (!binding)
      mistakes_.add(place(mark), "no parameter '" + name + "' here", suggest(name, known));
    else
      mistakes_.add(place(mark), "parameter '" + name + "' is " + kind_name(binding->value.kind),
                    "within a longer text only a number or text can stand");
    return "0";
  }

  const Bindings& bindings_;
  const int instance_;
  std::size_t& nodes_;
  Mistakes& mistakes_;
};

class Expander {
 public:
  Expander(YamlNode& root, Mistakes& mistakes) : root_(root), mistakes_(mistakes) {}

  void expand(const YamlNode& templates, const YamlNode& instances) {
    std::vector<std::string> names;
    for (std::size_t i = 0; i < templates.keys.size(); ++i) {  // a list has no keys, and was reported
      names.push_back(templates.keys[i].text);
      check_template(templates.keys[i].text, templates.items[i]);
    }
    if (instances.kind != YamlNode::Kind::kNull && !instances.is_sequence())
      mistakes_.add(instances.mark, "instances is not a list", "write `- {template: NAME, for: [{i: 1}, {i: 2}]}`");
    for (const YamlNode& item : instances.items) {
      YamlMap map(item, "an instance", mistakes_);
      const int choice = map.choice("template", "template", names);
      const std::vector<Bindings> rows = read_rows(map);
      map.finish();
      if (choice < 0) continue;
      const auto index = static_cast<std::size_t>(choice);
      if (map.find("count") != nullptr && !takes_counter(names[index], templates.items[index], *map.find("count")))
        continue;
      for (const Bindings& row : rows)
        if (!full_) make(names[index], templates.items[index], row, item);
    }
  }

 private:
  void check_template(const std::string& name, const YamlNode& node) {
    YamlMap map(node, "template '" + name + "'", mistakes_);
    for (const std::string& section : shared_sections())
      if (section != "constants" && section != "templates" && section != "instances") map.find(section);
    const YamlNode* parameters = map.find("parameters");
    if (parameters && !parameters->is_mapping())
      mistakes_.add(parameters->mark, "parameters is not a mapping",
                    "write {i, angle: 90 deg}: names, some with a default");
    map.finish();
  }

  // Returns true if `count` gives the parameter i, and no other.
  bool takes_counter(const std::string& name, const YamlNode& from, const YamlNode& count) {
    const YamlNode* parameters = from.find("parameters");
    if (parameters != nullptr && parameters->find(kCounter) != nullptr) return true;
    const YamlNode none;
    const YamlNode& listed = parameters != nullptr ? *parameters : none;
    std::string example;
    for (std::size_t i = 0; i < listed.keys.size() && example.empty(); ++i)
      if (listed.items[i].kind == YamlNode::Kind::kNull) example = listed.keys[i].text;
    mistakes_.add(
        count.mark, "`count` gives the parameter 'i', from 1, and template '" + name + "' has none of that name",
        example.empty() ? "declare it: parameters: {i}"
                        : "name its parameter i, or write `for: [{" + example + ": 1}, {" + example + ": 2}]`");
    return false;
  }

  // Reads the rows. `for`: a list of mappings from parameters to values; `count: n`: i from 1 to n.
  std::vector<Bindings> read_rows(YamlMap& map) {
    std::vector<Bindings> rows;
    const std::string by = map.only_one_of({"for", "count"}, "to say how many");
    if (by == "count") {
      const double count = read_bounded(map, get_number_key("scenario.instance.count"), {}, mistakes_);
      const YamlNode& node = *map.find("count");
      for (int i = 1; i <= static_cast<int>(count); ++i)
        rows.push_back({{kCounter, {YamlNode::Kind::kScalar, node.mark, std::to_string(i), {}, {}, false}}});
    } else if (by == "for") {
      const YamlNode& list = *map.find("for");
      if (!list.is_sequence()) mistakes_.add(list.mark, "for is not a list", "write [{i: 1}, {i: 2}]");
      for (const YamlNode& item : list.items) {
        Bindings row;
        YamlMap inner(item, "a row of parameters", mistakes_);
        for (std::size_t k = 0; k < item.keys.size(); ++k) {
          inner.find(item.keys[k].text);
          if (find_binding(row, item.keys[k].text) == nullptr) row.push_back({item.keys[k].text, item.items[k]});
        }
        inner.finish();
        rows.push_back(std::move(row));
      }
    }
    return rows;
  }

  // Sets the template's parameters in their order, from the row or from their default, which may refer to earlier ones.
  bool bind(const YamlNode& from, const Bindings& row, const YamlNode& instance, Bindings& bindings) {
    const std::size_t before = mistakes_.count();
    const YamlNode none;
    const YamlNode* parameters = from.find("parameters");
    if (!parameters) parameters = &none;
    std::vector<std::string> names;
    for (std::size_t i = 0; i < parameters->keys.size(); ++i) {
      const std::string& name = parameters->keys[i].text;
      names.push_back(name);
      if (!is_name(name))
        mistakes_.add(parameters->keys[i].mark, "'" + name + "' cannot be the name of a parameter",
                      describe_name_rule(name));
      const YamlNode& fallback = parameters->items[i];
      if (const Binding* given = find_binding(row, name))
        bindings.push_back(*given);
      else if (fallback.kind != YamlNode::Kind::kNull)
        bindings.push_back({name, Substitution(bindings, -1, nodes_, mistakes_).copy(fallback)});
      else {
        mistakes_.add(instance.mark, "parameter '" + name + "' has no value", "give it in each row of `for`");
        bindings.push_back({name, {YamlNode::Kind::kScalar, fallback.mark, "0", {}, {}, false}});  // reported once
      }
    }
    for (const Binding& given : row)
      if (std::find(names.begin(), names.end(), given.name) == names.end())
        mistakes_.add(given.value.mark, "the template has no parameter '" + given.name + "'",
                      suggest(given.name, names));
    return mistakes_.count() == before;
  }

  void make(const std::string& name, const YamlNode& from, const Bindings& row, const YamlNode& instance) {
    Bindings bindings;
    if (!from.is_mapping() || !bind(from, row, instance, bindings)) return;
    std::string values;
    for (const Binding& binding : bindings)
      if (binding.value.is_scalar() && values.size() < 40)
        values += (values.empty() ? ": " : ", ") + binding.name + " " + binding.value.text;
    Substitution substitution(bindings, mistakes_.add_instance(name + values), nodes_, mistakes_);
    for (std::size_t i = 0; i < from.keys.size(); ++i) {
      const std::vector<std::string>& shared = shared_sections();  // other keys are parameters, or were reported
      if (std::find(shared.begin(), shared.end(), from.keys[i].text) == shared.end()) continue;
      YamlNode made = substitution.copy(from.items[i]);
      YamlNode* section = root_.find(from.keys[i].text);
      if (!section) {
        root_.keys.push_back(from.keys[i]);
        root_.items.push_back(std::move(made));
      } else if (!append_section(*section, std::move(made))) {
        mistakes_.add(from.items[i].mark, from.keys[i].text + " of the template and of the scenario do not go together",
                      "make both a list, or both a mapping");
      }
    }
    if (nodes_ > kMaxNodes && !full_) {
      full_ = true;
      mistakes_.add(instance.mark, "templates make more than 200,000 values, or 32 levels of them",
                    "make fewer instances");
    }
  }

  YamlNode& root_;
  Mistakes& mistakes_;
  std::size_t nodes_ = 0;
  bool full_ = false;
};

// Removes a key from the mapping and returns its value; a null node if it is absent.
YamlNode take_section(YamlNode& root, const char* name) {
  for (std::size_t i = 0; i < root.keys.size(); ++i) {
    if (root.keys[i].text != name) continue;
    YamlNode section = std::move(root.items[i]);
    root.keys.erase(root.keys.begin() + static_cast<std::ptrdiff_t>(i));
    root.items.erase(root.items.begin() + static_cast<std::ptrdiff_t>(i));
    return section;
  }
  return {};
}

}  // namespace

void expand_templates(YamlNode& root, Mistakes& mistakes) {
  if (!root.is_mapping()) return;
  const YamlNode templates = take_section(root, "templates"), instances = take_section(root, "instances");
  if (templates.kind != YamlNode::Kind::kNull) {
    YamlMap map(templates, "templates", mistakes);  // a mapping, or a mistake
    for (const YamlKey& key : templates.keys) map.find(key.text);
    map.finish();  // names that are given twice, for one in an included file too
  }
  Expander(root, mistakes).expand(templates, instances);
}

}  // namespace unlatch::hil
