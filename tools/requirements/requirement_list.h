// Requirements as tools for requirements exchange them: ReqIF 1.2 (OMG formal/2016-07-01) and CSV. Identifier, text,
// parent and rationale go both ways. The criterion, by which runs judge, goes out only: no such tool can state it.
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "hil/scenario/scenario.h"

namespace unlatch::tools {

struct ListedRequirement {
  std::string id, text, parent, rationale;
  std::string criterion;  // "clearance core – pod2 from release:pod: at least 0.1 m"
};

// Those of a scenario, in its order.
std::vector<ListedRequirement> list_requirements(const hil::Scenario& scenario);

// "at least 0.1 m", "between 1 and 2 s"
std::string describe_limit(const hil::Requirement& requirement);

// Names of the attributes or columns that an import reads; empty: the usual ones.
struct AttributeNames {
  std::string id, text, parent, rationale;
};

class RequirementError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// `time`: of creation and last change, as xsd:dateTime. The same requirements give the same bytes.
std::string write_reqif(const std::vector<ListedRequirement>& list, const std::string& title, const std::string& time);
// Spec objects that have a text, in the order of the file. A parent is that of the attribute, else the nearest object
// above it in the hierarchy. Throws RequirementError.
std::vector<ListedRequirement> read_reqif(const std::string& text, const AttributeNames& names);

// RFC 4180; the first row has the names of the columns.
std::string write_requirements(const std::vector<ListedRequirement>& list);
// Comma, semicolon or tab. Throws RequirementError.
std::vector<ListedRequirement> read_requirements(const std::string& text, const AttributeNames& names);

// The text in one line: white space and control characters are one space. Throws RequirementError if it is not UTF-8.
std::string to_line(std::string_view text);

// The index of the name among `known`, ignoring case: `given`, or if that is empty the first of `usual` that is there;
// known.size() if there is none.
std::size_t find_attribute(const std::vector<std::string>& known, const std::string& given,
                           const std::vector<std::string>& usual);

extern const std::vector<std::string> kUsualIds, kUsualTexts, kUsualParents, kUsualRationales;

// A part for scenarios, `include: FILE`, that sets text, parent and rationale of the requirements that `scenario` has.
// The others are in comments, to be added by hand with a quantity and a limit. Throws RequirementError if the list has
// one twice.
struct ImportedPart {
  std::string text;
  std::size_t set = 0;               // requirements that it sets
  std::vector<std::string> missing;  // identifiers of the file that the scenario has not
  std::vector<std::string> unknown;  // of the scenario, which the file has not
};
ImportedPart write_part(const std::vector<ListedRequirement>& list, const hil::Scenario& scenario,
                        const std::string& file);

}  // namespace unlatch::tools
