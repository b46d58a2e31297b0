#include "hil/scenario/yaml/yaml_document.h"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/parser.h>

#include <algorithm>
#include <cstdint>
#include <sstream>

#include "hil/scenario/text/count.h"
#include "hil/scenario/text/utf8.h"

namespace unlatch::hil {
namespace {

constexpr std::size_t kMaxBytes = 1u << 20;
constexpr std::size_t kMaxDepth = 32;
constexpr std::size_t kMaxNodes = 200'000;

// Place of a tab in the indentation, at or before the place of the parser's error: 0 if there is none.
SourceMark find_tab(const std::string& text, const SourceMark& gave_up) {
  SourceMark found = gave_up;
  found.line = 0;
  std::size_t begin = 0;
  for (int line = 1; line <= gave_up.line + 1 && begin < text.size(); ++line) {
    const std::size_t first = text.find_first_not_of(' ', begin);
    if (first != std::string::npos && text[first] == '\t') {
      found.line = line;
      found.column = static_cast<int>(first - begin) + 1;
    }
    const std::size_t end = text.find('\n', begin);
    begin = end == std::string::npos ? text.size() : end + 1;
  }
  return found;
}

// Refuses bytes that are not text, which yaml-cpp accepts.
void check_bytes(std::string_view text, int override_index, int file) {
  if (text.size() > kMaxBytes)
    throw YamlError({0, 0, override_index, file}, "it has " + count(text.size(), "byte"),
                    "a scenario has at most 1 MiB");
  SourceMark mark{1, 1, override_index, file};
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = get_utf8_length(text, i);
    const auto byte = static_cast<std::uint8_t>(text[i]);
    if (length == 0) throw YamlError(mark, "a byte that is not UTF-8", "save the file as UTF-8 text");
    const bool control = (byte < 0x20 && byte != '\n' && byte != '\r' && byte != '\t') || byte == 0x7f;
    const bool c1 = length == 2 && byte == 0xc2 && static_cast<std::uint8_t>(text[i + 1]) < 0xa0;
    if (control || c1) throw YamlError(mark, "a control byte", "remove it: a scenario is plain text");
    mark.column = byte == '\n' ? 1 : mark.column + 1;
    mark.line += byte == '\n' ? 1 : 0;
    i += length;
  }
}

// Builds the tree from the parser's events and enforces the bounds meanwhile.
class TreeBuilder : public YAML::EventHandler {
 public:
  TreeBuilder(int override_index, int file) : override_index_(override_index), file_(file) {}
  YamlNode take_root() { return std::move(root_); }

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    begin(YamlNode::Kind::kNull, mark, "", anchor);
    end();
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override { refuse_anchor(mark); }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& value) override {
    begin(YamlNode::Kind::kScalar, mark, tag, anchor).text = value;
    end();
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    begin(YamlNode::Kind::kSequence, mark, tag, anchor);
  }
  void OnSequenceEnd() override { end(); }
  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    begin(YamlNode::Kind::kMapping, mark, tag, anchor);
  }
  void OnMapEnd() override { end(); }

 private:
  SourceMark place(const YAML::Mark& mark) const { return {mark.line + 1, mark.column + 1, override_index_, file_}; }
  [[noreturn]] void refuse_anchor(const YAML::Mark& mark) const {
    throw YamlError(place(mark), "an anchor or alias (& or *)", "write the value out");
  }

  YamlNode& begin(YamlNode::Kind kind, const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor) {
    if (anchor != 0) refuse_anchor(mark);
    if (!tag.empty() && tag != "?" && tag != "!") throw YamlError(place(mark), "the tag " + tag, "leave tags out");
    if (++nodes_ > kMaxNodes) throw YamlError(place(mark), "more than 200,000 values", "make the scenario smaller");
    if (open_.size() >= kMaxDepth)
      throw YamlError(place(mark), "more than 32 levels of nesting", "nest the values less deeply");
    open_.push_back({});
    open_.back().kind = kind;
    open_.back().mark = place(mark);
    return open_.back();
  }

  // Completes the innermost open node and adds it to its parent, as an item, a key or a value.
  void end() {
    YamlNode node = std::move(open_.back());
    open_.pop_back();
    if (open_.empty()) {
      root_ = std::move(node);
      return;
    }
    YamlNode& parent = open_.back();
    if (parent.is_mapping() && parent.keys.size() == parent.items.size()) {
      if (!node.is_scalar()) throw YamlError(node.mark, "a key that is not a name", "write `name: value`");
      parent.keys.push_back({std::move(node.text), node.mark});
    } else {
      parent.items.push_back(std::move(node));
    }
  }

  int override_index_, file_;
  std::size_t nodes_ = 0;
  std::vector<YamlNode> open_;
  YamlNode root_;
};

}  // namespace

const YamlNode* YamlNode::find(std::string_view key) const {
  if (!is_mapping()) return nullptr;
  const auto at = std::find_if(keys.begin(), keys.end(), [&](const YamlKey& k) { return k.text == key; });
  return at == keys.end() ? nullptr : &items[static_cast<std::size_t>(at - keys.begin())];
}

YamlNode* YamlNode::find(std::string_view key) { return const_cast<YamlNode*>(std::as_const(*this).find(key)); }

YamlNode make_scalar(std::string text) {
  YamlNode node;
  node.kind = YamlNode::Kind::kScalar;
  node.text = std::move(text);
  return node;
}

const char* kind_name(YamlNode::Kind kind) {
  switch (kind) {
    case YamlNode::Kind::kNull:
      return "nothing";
    case YamlNode::Kind::kScalar:
      return "a single value";
    case YamlNode::Kind::kSequence:
      return "a list";
    case YamlNode::Kind::kMapping:
      return "a mapping";
  }
  return "";
}

YamlNode parse_yaml(const std::string& text, int override_index, int file) {
  check_bytes(text, override_index, file);
  try {
    std::istringstream stream(text);
    YAML::Parser parser(stream);
    TreeBuilder builder(override_index, file);
    if (!parser.HandleNextDocument(builder)) return {};
    TreeBuilder second(override_index, file);
    if (parser.HandleNextDocument(second))
      throw YamlError(second.take_root().mark, "a second document (---)", "one scenario a file");
    return builder.take_root();
  } catch (const YAML::Exception& e) {
    const SourceMark mark{e.mark.line + 1, e.mark.column + 1, override_index, file};
    if (const SourceMark tab = find_tab(text, mark); tab.line > 0)
      throw YamlError(tab, "a tab in the indentation", "indent with spaces: YAML allows no tabs there");
    throw YamlError(mark, "not YAML: " + e.msg, "check indentation, colons and brackets");
  }
}

}  // namespace unlatch::hil
