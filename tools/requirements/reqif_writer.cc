// ReqIF, written: one type of spec objects, one specification whose hierarchy follows the parents within the list.
// Attributes have the names of the ReqIF implementation guide, as tools expect them.
#include <algorithm>
#include <functional>

#include "hil/scenario/text/xml_text.h"
#include "tools/requirements/requirement_list.h"

namespace unlatch::tools {
namespace {

using hil::escape_xml;

struct Attribute {
  const char *id, *name;
  bool formatted;
  std::string ListedRequirement::*value;
};

const std::vector<Attribute> kAttributes{{"attribute-id", "ReqIF.ForeignID", false, &ListedRequirement::id},
                                         {"attribute-text", "ReqIF.Text", true, &ListedRequirement::text},
                                         {"attribute-rationale", "Rationale", true, &ListedRequirement::rationale},
                                         {"attribute-parent", "Parent", false, &ListedRequirement::parent},
                                         {"attribute-criterion", "Criterion", false, &ListedRequirement::criterion}};

class Writer {
 public:
  Writer(const std::vector<ListedRequirement>& list, std::string title, std::string time)
      : list_(list), title_(escape_xml(title)), time_(escape_xml(time)) {}

  std::string write() {
    line(0, R"(<?xml version="1.0" encoding="UTF-8"?>)");
    line(
        0,
        R"(<REQ-IF xmlns="http://www.omg.org/spec/ReqIF/20110401/reqif.xsd" xmlns:xhtml="http://www.w3.org/1999/xhtml">)");
    line(1, "<THE-HEADER>");
    line(2, R"(<REQ-IF-HEADER IDENTIFIER="header">)");
    line(3, "<CREATION-TIME>" + time_ + "</CREATION-TIME>");
    line(3, "<REQ-IF-TOOL-ID>unlatch</REQ-IF-TOOL-ID>");
    line(3, "<REQ-IF-VERSION>1.0</REQ-IF-VERSION>");
    line(3, "<SOURCE-TOOL-ID>unlatch</SOURCE-TOOL-ID>");
    line(3, "<TITLE>" + title_ + "</TITLE>");
    line(2, "</REQ-IF-HEADER>");
    line(1, "</THE-HEADER>");
    line(1, "<CORE-CONTENT>");
    line(2, "<REQ-IF-CONTENT>");
    write_types();
    line(3, "<SPEC-OBJECTS>");
    for (std::size_t i = 0; i < list_.size(); ++i) write_object(i);
    line(3, "</SPEC-OBJECTS>");
    write_specification();
    line(2, "</REQ-IF-CONTENT>");
    line(1, "</CORE-CONTENT>");
    line(0, "</REQ-IF>");
    return std::move(out_);
  }

 private:
  void line(int depth, const std::string& text) {
    out_ += std::string(static_cast<std::size_t>(2 * depth), ' ') + text + "\n";
  }
  // IDENTIFIER and the time, which every element with an identifier has.
  std::string identify(const std::string& id) const {
    return " IDENTIFIER=\"" + id + "\" LAST-CHANGE=\"" + time_ + "\"";
  }
  // An identifier that follows from that of the requirement alone, so that it stays when others come before it. It is
  // an xsd:ID: what such a name cannot have, and the point itself, becomes a point and the byte's hexadecimal digits.
  std::string name(const char* kind, std::size_t i) const {
    static constexpr char kDigits[] = "0123456789abcdef";
    std::string id = kind;
    for (const char c : list_[i].id) {
      const bool plain =
          (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
      const auto byte = static_cast<unsigned char>(c);
      if (plain)
        id += c;
      else
        id.append({'.', kDigits[byte >> 4], kDigits[byte & 15]});
    }
    return id;
  }

  void write_types() {
    line(3, "<DATATYPES>");
    line(4, "<DATATYPE-DEFINITION-STRING" + identify("type-string") + R"( LONG-NAME="String" MAX-LENGTH="32000"/>)");
    line(4, "<DATATYPE-DEFINITION-XHTML" + identify("type-xhtml") + R"( LONG-NAME="XHTML"/>)");
    line(3, "</DATATYPES>");
    line(3, "<SPEC-TYPES>");
    line(4, "<SPEC-OBJECT-TYPE" + identify("type-requirement") + R"( LONG-NAME="Requirement">)");
    line(5, "<SPEC-ATTRIBUTES>");
    for (const Attribute& one : kAttributes) {
      const std::string kind = one.formatted ? "XHTML" : "STRING", type = one.formatted ? "type-xhtml" : "type-string";
      line(6, "<ATTRIBUTE-DEFINITION-" + kind + identify(one.id) + " LONG-NAME=\"" + one.name + "\">");
      line(7, "<TYPE>");
      line(8, "<DATATYPE-DEFINITION-" + kind + "-REF>" + type + "</DATATYPE-DEFINITION-" + kind + "-REF>");
      line(7, "</TYPE>");
      line(6, "</ATTRIBUTE-DEFINITION-" + kind + ">");
    }
    line(5, "</SPEC-ATTRIBUTES>");
    line(4, "</SPEC-OBJECT-TYPE>");
    line(4, "<SPECIFICATION-TYPE" + identify("type-specification") + R"( LONG-NAME="Specification"/>)");
    line(3, "</SPEC-TYPES>");
  }

  void write_object(std::size_t i) {
    line(4, "<SPEC-OBJECT" + identify(name("requirement-", i)) + " LONG-NAME=\"" + escape_xml(list_[i].id) + "\">");
    line(5, "<TYPE>");
    line(6, "<SPEC-OBJECT-TYPE-REF>type-requirement</SPEC-OBJECT-TYPE-REF>");
    line(5, "</TYPE>");
    line(5, "<VALUES>");
    for (const Attribute& one : kAttributes)
      if (!(list_[i].*one.value).empty()) write_value(one, escape_xml(list_[i].*one.value));
    line(5, "</VALUES>");
    line(4, "</SPEC-OBJECT>");
  }

  void write_value(const Attribute& one, const std::string& value) {
    const std::string kind = one.formatted ? "XHTML" : "STRING";
    line(6, "<ATTRIBUTE-VALUE-" + kind + (one.formatted ? ">" : " THE-VALUE=\"" + value + "\">"));
    line(7, "<DEFINITION>");
    line(8, "<ATTRIBUTE-DEFINITION-" + kind + "-REF>" + one.id + "</ATTRIBUTE-DEFINITION-" + kind + "-REF>");
    line(7, "</DEFINITION>");
    if (one.formatted) line(7, "<THE-VALUE><xhtml:div>" + value + "</xhtml:div></THE-VALUE>");
    line(6, "</ATTRIBUTE-VALUE-" + kind + ">");
  }

  void write_specification() {
    line(3, "<SPECIFICATIONS>");
    line(4, "<SPECIFICATION" + identify("specification") + " LONG-NAME=\"" + title_ + "\">");
    line(5, "<TYPE>");
    line(6, "<SPECIFICATION-TYPE-REF>type-specification</SPECIFICATION-TYPE-REF>");
    line(5, "</TYPE>");
    write_children(list_.size(), 5);
    line(4, "</SPECIFICATION>");
    line(3, "</SPECIFICATIONS>");
  }

  // Index of the parent within the list. None, list_.size(): outside of it, or in a circle of parents.
  std::size_t find_parent(std::size_t i) const {
    const std::size_t none = list_.size();
    const auto find = [&](std::size_t of) {
      const auto at = std::ranges::find(list_, list_[of].parent, &ListedRequirement::id);
      return list_[of].parent.empty() ? none : static_cast<std::size_t>(at - list_.begin());
    };
    std::size_t above = find(i);
    for (std::size_t steps = 0; above != none; ++steps, above = find(above))
      if (above == i || steps > list_.size()) return none;
    return find(i);
  }

  // `parent`: list_.size() for the specification itself.
  void write_children(std::size_t parent, int depth) {
    bool any = false;
    for (std::size_t i = 0; i < list_.size(); ++i) {
      if (find_parent(i) != parent) continue;
      if (!any) line(depth, "<CHILDREN>");
      any = true;
      line(depth + 1, "<SPEC-HIERARCHY" + identify(name("place-", i)) + ">");
      line(depth + 2, "<OBJECT>");
      line(depth + 3, "<SPEC-OBJECT-REF>" + name("requirement-", i) + "</SPEC-OBJECT-REF>");
      line(depth + 2, "</OBJECT>");
      write_children(i, depth + 2);
      line(depth + 1, "</SPEC-HIERARCHY>");
    }
    if (any) line(depth, "</CHILDREN>");
  }

  const std::vector<ListedRequirement>& list_;
  const std::string title_, time_;
  std::string out_;
};

}  // namespace

std::string write_reqif(const std::vector<ListedRequirement>& list, const std::string& title, const std::string& time) {
  return Writer(list, title, time).write();
}

}  // namespace unlatch::tools
