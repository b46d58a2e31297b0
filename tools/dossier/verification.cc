#include "tools/dossier/verification.h"

#include <algorithm>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "commit.h"
#include "hil/run/recording/log_format.h"
#include "tools/pages/embed.h"

UNLATCH_EMBED_FILE(unlatch_validation_text, UNLATCH_VALIDATION_FILE);
UNLATCH_EMBED_FILE(unlatch_tests_text, UNLATCH_TESTS_FILE);

namespace unlatch::tools {
namespace {

using Json = nlohmann::ordered_json;

// A block of Markdown: a heading, a paragraph, an item of a list, a row of a table.
struct Block {
  enum class Kind { kHeading, kParagraph, kItem, kRow };
  Kind kind;
  std::string text;
  std::vector<std::string> cells;
};

// Without links and emphasis; `code` stays as it is.
std::string simplify(std::string_view text) {
  std::string out;
  bool code = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '`') code = !code;
    if (!code && text[i] == '[') {
      const std::size_t close = text.find(']', i);
      const bool is_link = close + 1 < text.size() && text[close + 1] == '(';
      if (const std::size_t end = is_link ? text.find(')', close) : std::string_view::npos;
          end != std::string_view::npos) {
        out += text.substr(i + 1, close - i - 1);
        i = end;
        continue;
      }
    }
    if (code || text[i] != '*') out += text[i];
  }
  return out;
}

std::vector<std::string> split_row(std::string_view line) {
  std::vector<std::string> cells;
  line.remove_prefix(1);
  while (!line.empty()) {
    const std::size_t end = std::min(line.find(" |"), line.size());
    std::string_view cell = line.substr(0, end);
    while (cell.starts_with(' ')) cell.remove_prefix(1);
    cells.push_back(simplify(cell));
    line.remove_prefix(std::min(line.size(), end + 2));
  }
  return cells;
}

std::vector<Block> read_markdown(std::string_view text) {
  std::vector<Block> blocks;
  bool joins = false;  // the next line belongs to the last block
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    if (line.empty()) {
      joins = false;
    } else if (line.starts_with("#")) {
      blocks.push_back({Block::Kind::kHeading, std::string(line.substr(line.find_first_not_of("# "))), {}});
      joins = false;
    } else if (line.starts_with("|")) {
      if (!line.starts_with("|---")) blocks.push_back({Block::Kind::kRow, "", split_row(line)});
      joins = false;
    } else if (line.starts_with("- ")) {
      blocks.push_back({Block::Kind::kItem, simplify(line.substr(2)), {}});
      joins = true;
    } else if (joins) {
      blocks.back().text += " " + simplify(line.substr(line.find_first_not_of(' ')));
    } else {
      blocks.push_back({Block::Kind::kParagraph, simplify(line), {}});
      joins = true;
    }
  }
  return blocks;
}

// Blocks of some kinds under a heading.
std::vector<Block> get_section(const std::vector<Block>& blocks, std::string_view heading,
                               std::initializer_list<Block::Kind> kinds) {
  std::vector<Block> found;
  bool inside = false;
  for (const Block& block : blocks) {
    if (block.kind == Block::Kind::kHeading)
      inside = block.text == heading;
    else if (inside && std::ranges::find(kinds, block.kind) != kinds.end())
      found.push_back(block);
  }
  return found;
}

Json list_texts(const std::vector<Block>& blocks) {
  Json list = Json::array();
  for (const Block& block : blocks) list.push_back(block.text);
  return list;
}

// Rows below the heads of tables; `group`: the paragraph before each table.
Json list_promises(const std::vector<Block>& blocks) {
  Json list = Json::array();
  bool inside = false;
  std::string group;
  for (const Block& block : blocks) {
    if (block.kind == Block::Kind::kHeading) inside = block.text == "Promises and their tests";
    if (!inside) continue;
    if (block.kind == Block::Kind::kParagraph) group = block.text.substr(0, block.text.find(':'));
    if (block.kind == Block::Kind::kRow && block.cells.size() == 2 && block.cells[0] != "promise")
      list.push_back({{"group", group}, {"promise", block.cells[0]}, {"test", block.cells[1]}});
  }
  return list;
}

}  // namespace

Json build_verification_json() {
  const std::vector<Block> validation = read_markdown(UNLATCH_EMBEDDED_FILE(unlatch_validation_text));
  const std::vector<Block> tests = read_markdown(UNLATCH_EMBEDDED_FILE(unlatch_tests_text));
  Json verified = Json::array();
  for (const Block& row : get_section(validation, "Verified", {Block::Kind::kRow}))
    if (row.cells.size() == 3 && row.cells[0] != "what")
      verified.push_back({{"what", row.cells[0]}, {"compared_with", row.cells[1]}, {"agreement", row.cells[2]}});
  return {{"program", "unlatch " UNLATCH_VERSION},
          {"commit", UNLATCH_COMMIT},
          {"compiler", hil::get_compiler()},
          {"verified", verified},
          {"promises", list_promises(tests)},
          {"flights", list_texts(get_section(validation, "Beside published flights",
                                             {Block::Kind::kParagraph, Block::Kind::kItem}))},
          {"not_validated", list_texts(get_section(validation, "Not validated", {Block::Kind::kItem}))},
          {"known_to_be_wrong", list_texts(get_section(validation, "Known to be wrong", {Block::Kind::kItem}))}};
}

}  // namespace unlatch::tools
