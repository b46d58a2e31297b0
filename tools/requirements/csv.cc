#include <algorithm>
#include <cstddef>
#include <string_view>

#include "hil/scenario/text/suggestion.h"
#include "tools/common/text.h"
#include "tools/requirements/requirement_list.h"

namespace unlatch::tools {
namespace {

using Row = std::vector<std::string>;

constexpr std::size_t kMaxRows = 100'000, kMaxCells = 1000;

// Most frequent of the separators in the first line.
char find_separator(std::string_view text) {
  const std::string_view line = text.substr(0, text.find('\n'));
  char best = ',';
  std::ptrdiff_t most = 0;
  for (const char c : {',', ';', '\t'}) {
    const auto count = std::count(line.begin(), line.end(), c);
    if (count > most) {
      most = count;
      best = c;
    }
  }
  return best;
}

// Rows of cells; a cell in quotation marks may have line breaks.
std::vector<Row> split(std::string_view text, char separator) {
  std::vector<Row> rows(1, Row(1));
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    std::string& cell = rows.back().back();
    if (quoted && c == '"' && i + 1 < text.size() && text[i + 1] == '"') {
      cell += text[++i];
    } else if (c == '"' && (quoted || cell.empty())) {
      quoted = !quoted;
    } else if (!quoted && c == separator) {
      if (rows.back().size() >= kMaxCells) throw RequirementError("a row of more than 1000 cells");
      rows.back().emplace_back();
    } else if (!quoted && c == '\n') {
      if (rows.size() >= kMaxRows) throw RequirementError("more than 100,000 rows");
      rows.emplace_back(1);
    } else if (quoted || c != '\r') {
      cell += c;
    }
  }
  if (quoted) throw RequirementError("a quotation mark is not closed");
  return rows;
}

// Of two columns with one name, nothing says which is meant.
void refuse_second(const Row& head, std::size_t column) {
  for (std::size_t other = column + 1; other < head.size(); ++other)
    if (hil::to_lower(head[other]) == hil::to_lower(head[column]))
      throw RequirementError("line 1 has a second column '" + to_line(head[other]) + "'; give each its own name");
}

}  // namespace

std::string write_requirements(const std::vector<ListedRequirement>& list) {
  std::string text = "id,parent,text,rationale,criterion\r\n";
  for (const ListedRequirement& one : list)
    text += quote_cell(one.id) + "," + quote_cell(one.parent) + "," + quote_cell(one.text) + "," +
            quote_cell(one.rationale) + "," + quote_cell(one.criterion) + "\r\n";
  return text;
}

std::vector<ListedRequirement> read_requirements(const std::string& text, const AttributeNames& names) {
  std::string_view rest = text;
  if (rest.starts_with("\xef\xbb\xbf")) rest.remove_prefix(3);
  const std::vector<Row> rows = split(rest, find_separator(rest));
  const Row& head = rows.front();
  const std::size_t id = find_attribute(head, names.id, kUsualIds),
                    of_text = find_attribute(head, names.text, kUsualTexts);
  const std::size_t parent = find_attribute(head, names.parent, kUsualParents);
  const std::size_t rationale = find_attribute(head, names.rationale, kUsualRationales);
  if (id == head.size() || of_text == head.size())
    throw RequirementError("line 1 has no column for the " + std::string(id == head.size() ? "identifier" : "text") +
                           "; name it with --" + (id == head.size() ? "id" : "text"));
  for (const std::size_t column : {id, of_text, parent, rationale}) refuse_second(head, column);
  std::vector<ListedRequirement> list;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const auto get = [&](std::size_t column) { return column < rows[i].size() ? rows[i][column] : std::string(); };
    const std::string own = to_line(get(id));
    if (!own.empty()) list.push_back({own, to_line(get(of_text)), to_line(get(parent)), to_line(get(rationale)), ""});
  }
  return list;
}

}  // namespace unlatch::tools
