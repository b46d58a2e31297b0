#include "hil/scenario/language/scenario_parts.h"

#include <algorithm>
#include <filesystem>
#include <set>

#include "hil/scenario/yaml/yaml_override.h"
#include "hil/scenario/yaml/yaml_reader.h"

namespace unlatch::hil {
namespace {

constexpr int kLanguageVersion = 1;
constexpr std::size_t kMaxDepth = 8;

// Removes a key from a mapping and returns its values.
std::vector<YamlNode> take_key(YamlNode& map, const std::string& key) {
  std::vector<YamlNode> values;
  for (std::size_t i = 0; i < map.keys.size();) {
    if (map.keys[i].text != key) {
      ++i;
      continue;
    }
    values.push_back(std::move(map.items[i]));
    map.keys.erase(map.keys.begin() + static_cast<std::ptrdiff_t>(i));
    map.items.erase(map.items.begin() + static_cast<std::ptrdiff_t>(i));
  }
  return values;
}

// Reads files into one tree.
class Includer {
 public:
  Includer(ScenarioSources& sources, std::string folder, Mistakes& mistakes)
      : sources_(sources), folder_(std::move(folder)), mistakes_(mistakes) {}

  // Reads the tree of a file with all files that it includes, without the keys of inclusion. `name`: path from the
  // scenario's folder.
  YamlNode read(const std::string& text, const std::string& name, int file) {
    YamlNode own;
    try {
      own = parse_yaml(text, -1, file);
    } catch (const YamlError& e) {
      mistakes_.add(e.mark, e.what(), e.mend);
      mistakes_.throw_if_any();
    }
    if (!own.is_mapping()) return own;
    check_version(own, file > 0);
    open_.push_back(name);
    YamlNode whole;
    whole.kind = YamlNode::Kind::kMapping;
    whole.mark = own.mark;
    for (const YamlNode& include : take_key(own, "include")) read_includes(include, name, whole);
    for (YamlNode& set : take_key(own, "set")) sets_.push_back(std::move(set));
    merge(std::move(own), whole);
    open_.pop_back();
    return whole;
  }

  // True if a file is missing from the tree: other mistakes may follow from that.
  bool is_incomplete() const { return incomplete_; }

  // Applies PATH: value of all files, those of included files first.
  void apply_sets(YamlNode& root) {
    for (YamlNode& set : sets_) {
      if (!set.is_mapping()) mistakes_.add(set.mark, "set is not a mapping", "write `bodies.core.mass: 98 t`");
      for (std::size_t i = 0; i < set.keys.size(); ++i) try {
          replace_value(set.keys[i].text, set.keys[i].mark, std::move(set.items[i]), root);
        } catch (const YamlError& e) {
          mistakes_.add(e.mark, e.what(), e.mend);
        }
    }
  }

 private:
  // Checks the version. An included file is a scenario, or a part that cannot be used alone. The reader sees the main
  // file's version only.
  void check_version(YamlNode& tree, bool included) {
    const YamlNode* part = tree.find("unlatch_part");
    const YamlNode* version = part && included ? part : tree.find("unlatch");
    if (part && !included)
      mistakes_.add(part->mark, "this file is a part of scenarios", "a scenario names it: `include: FILE`");
    else if (!version && included)
      mistakes_.add(tree.mark, "missing header", "add `unlatch_part: 1`");
    else if (included && read_number(*version, "", kLanguageVersion, mistakes_) != kLanguageVersion)
      mistakes_.add(version->mark, "another version of the language", "this program reads version 1");
    take_key(tree, "unlatch_part");
    if (included) take_key(tree, "unlatch");
  }

  void read_includes(const YamlNode& include, const std::string& from, YamlNode& whole) {
    if (include.is_scalar()) return read_include(include, from, whole);
    if (!include.is_sequence()) mistakes_.add(include.mark, "include names no file", "write `include: parts.yaml`");
    for (const YamlNode& item : include.items) read_include(item, from, whole);
  }

  void read_include(const YamlNode& node, const std::string& from, YamlNode& whole) {
    const auto reject = [&](const std::string& what, const std::string& mend) {
      incomplete_ = true;
      mistakes_.add(node.mark, "cannot include '" + node.text + "': " + what, mend);
    };
    const std::string mend = "a path from this file to one in or below the scenario's folder";
    if (!node.is_scalar()) return mistakes_.add(node.mark, "include names no file", "write `include: parts.yaml`");
    if (open_.size() >= kMaxDepth) return reject("more than 8 files deep", "include them from fewer files");
    try {
      const std::string name = resolve_include(from, node.text);
      if (const auto first = std::find(open_.begin(), open_.end(), name); first != open_.end()) {
        std::string cycle;
        for (auto at = first; at != open_.end(); ++at) cycle += *at + " → ";
        return reject("it would include itself: " + cycle + name, "leave out one of these includes");
      }
      if (!seen_.insert(name).second) return;  // each file is included once
      const std::string text = sources_.read(name);
      const int file = mistakes_.add_file((std::filesystem::path(folder_) / name).string());
      merge(read(text, name, file), whole);
    } catch (const std::runtime_error& e) {
      if (dynamic_cast<const ScenarioError*>(&e)) throw;
      reject(e.what(), mend);
    }
  }

  // Merges sections that are in both: entries of shared sections are joined; of other sections the later one is kept.
  static void merge(YamlNode&& from, YamlNode& to) {
    if (!from.is_mapping()) return;
    const std::vector<std::string>& shared = shared_sections();
    const std::size_t before = to.keys.size();
    for (std::size_t i = 0; i < from.keys.size(); ++i) {
      YamlKey& key = from.keys[i];
      std::size_t at = 0;
      while (at < before && to.keys[at].text != key.text) ++at;
      if (at == before) {  // new, or a duplicate within its own file, which the reader reports
        to.keys.push_back(std::move(key));
        to.items.push_back(std::move(from.items[i]));
        continue;
      }
      const bool both = std::find(shared.begin(), shared.end(), key.text) != shared.end();
      if (both && append_section(to.items[at], std::move(from.items[i]))) continue;
      to.keys[at] = std::move(key);
      to.items[at] = std::move(from.items[i]);
    }
  }

  ScenarioSources& sources_;
  std::string folder_;
  Mistakes& mistakes_;
  std::vector<std::string> open_;  // names of the files being read
  std::set<std::string> seen_;
  std::vector<YamlNode> sets_;
  bool incomplete_ = false;
};

}  // namespace

const std::vector<std::string>& shared_sections() {
  static const std::vector<std::string> names{
      "constants", "bodies", "joints", "elements",     "channels",  "sensors",   "signals",    "events", "clearance",
      "contacts",  "points", "stops",  "requirements", "templates", "instances", "quantities", "basis"};
  return names;
}

bool append_section(YamlNode& to, YamlNode&& from) {
  if (to.kind != from.kind || !(to.is_mapping() || to.is_sequence())) return false;
  for (YamlKey& key : from.keys) to.keys.push_back(std::move(key));
  for (YamlNode& item : from.items) to.items.push_back(std::move(item));
  return true;
}

YamlNode build_tree(ScenarioSources& sources, const std::string& file, Mistakes& mistakes) {
  const std::filesystem::path path(file);
  Includer includer(sources, path.parent_path().string(), mistakes);
  YamlNode root = includer.read(sources.main(), path.filename().string(), 0);
  if (includer.is_incomplete()) mistakes.throw_if_any();
  expand_templates(root, mistakes);
  includer.apply_sets(root);
  return root;
}

}  // namespace unlatch::hil
