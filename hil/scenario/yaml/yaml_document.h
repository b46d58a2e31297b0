// A YAML text as a tree of nodes with their places. The text comes from outside, so it is bounded before and while it
// is read: at most 1 MiB, valid UTF-8 without control bytes, at most 32 levels and 200,000 nodes, one document, no
// anchors, aliases or tags. Nodes of the tree are not shared, so a walk over it visits each node once.
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace unlatch::hil {

// A position in the text: line and column count from 1; 0 is "the file as a whole". A value from an override has the
// override's number instead. Mistakes numbers files and instances of templates.
struct SourceMark {
  int line = 0;
  int column = 0;
  int override_index = -1;
  int file = 0;
  int instance = -1;  // instance of the template
};

struct YamlNode;

struct YamlKey {
  enum class Origin { kFile, kAdded, kReplaced };  // by an override, or by `set`
  std::string text;
  SourceMark mark;
  Origin origin = Origin::kFile;  // of the key, or of the value that stands under it
};

struct YamlNode {
  enum class Kind { kNull, kScalar, kSequence, kMapping };
  Kind kind = Kind::kNull;
  SourceMark mark;
  std::string text;             // text of a scalar
  std::vector<YamlKey> keys;    // keys of a mapping, in the order of the file, duplicates included
  std::vector<YamlNode> items;  // items of a sequence, or the values of a mapping
  bool sparse = false;          // sequence created by an override: its null items mean "the default"

  bool is_scalar() const { return kind == Kind::kScalar; }
  bool is_text(std::string_view wanted) const { return is_scalar() && text == wanted; }
  bool is_sequence() const { return kind == Kind::kSequence; }
  bool is_mapping() const { return kind == Kind::kMapping; }
  const YamlNode* find(std::string_view key) const;  // the first value of that key, or null
  YamlNode* find(std::string_view key);
};

// Scalar with this text, without a place.
YamlNode make_scalar(std::string text);

// Kind of a node in words: "a number or text", "a list", "a mapping", "nothing".
const char* kind_name(YamlNode::Kind kind);

// Error of a text that is not YAML, or beyond the bounds.
class YamlError : public std::runtime_error {
 public:
  YamlError(SourceMark mark_in, const std::string& what_in, std::string mend_in)
      : std::runtime_error(what_in), mark(mark_in), mend(std::move(mend_in)) {}
  SourceMark mark;
  std::string mend;
};

// Parses a text. Throws YamlError. All marks carry `override_index` and `file`.
YamlNode parse_yaml(const std::string& text, int override_index = -1, int file = 0);

}  // namespace unlatch::hil
