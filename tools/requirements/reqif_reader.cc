// ReqIF, read with Expat. Prefixes of namespaces differ from tool to tool, so elements are known by their local names.
#include <expat.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <memory>
#include <string_view>

#include "tools/requirements/requirement_list.h"

namespace unlatch::tools {
namespace {

using Attributes = const XML_Char**;

constexpr std::size_t kMaxDepth = 256, kMaxText = 64'000'000;  // elements; bytes
constexpr std::size_t kNone = static_cast<std::size_t>(-1);

std::string_view get_local(const XML_Char* name) {
  const std::string_view whole(name);
  const std::size_t at = whole.rfind('|');
  return at == std::string_view::npos ? whole : whole.substr(at + 1);
}

std::string find(Attributes attributes, std::string_view name) {
  for (; *attributes != nullptr; attributes += 2)
    if (name == attributes[0]) return attributes[1];
  return {};
}

// An element of XHTML that begins a line: its text is apart from what is before it.
bool is_block(std::string_view element) {
  static constexpr std::string_view kBlocks[]{"p",  "div", "br", "li", "ul", "ol", "table",
                                              "tr", "td",  "th", "h1", "h2", "h3", "pre"};
  return std::ranges::find(kBlocks, element) != std::end(kBlocks);
}

struct Object {
  std::string id, name;
  std::map<std::string, std::string> values;  // by the identifier of the attribute's definition
};
struct Place {  // in the hierarchy
  std::size_t above = kNone;
  std::string object;
};

class Reader {
 public:
  std::vector<Object> objects;
  std::vector<Place> places;
  std::map<std::string, std::string> attribute_names;  // by identifier
  bool is_reqif = false;
  std::string failure;
  XML_Parser parser = nullptr;

  static void begin(void* self, const XML_Char* element, Attributes attributes) {
    static_cast<Reader*>(self)->begin(get_local(element), attributes);
  }
  static void end(void* self, const XML_Char* element) { static_cast<Reader*>(self)->end(get_local(element)); }
  static void text(void* self, const XML_Char* characters, int length) {
    auto& reader = *static_cast<Reader*>(self);
    if (reader.takes_text_) reader.text_.append(characters, static_cast<std::size_t>(length));
  }
  static void refuse_types(void* self, const XML_Char*, const XML_Char*, const XML_Char*, int) {
    static_cast<Reader*>(self)->fail("it has a document type; ReqIF has none");
  }

 private:
  void fail(const std::string& why) {
    if (failure.empty()) failure = why;
    XML_StopParser(parser, XML_FALSE);
  }

  void begin(std::string_view element, Attributes attributes) {
    if (stack_.empty()) is_reqif = element == "REQ-IF";
    if (stack_.size() >= kMaxDepth) return fail("more than 256 elements deep");
    stack_.emplace_back(element);
    if (formatted_ > 0) {
      ++formatted_;
      if (is_block(element) && !text_.empty() && text_.back() != ' ') text_ += ' ';
    } else if (element == "SPEC-OBJECT") {
      objects.push_back({find(attributes, "IDENTIFIER"), to_line(find(attributes, "LONG-NAME")), {}});
    } else if (element.starts_with("ATTRIBUTE-DEFINITION-") && !element.ends_with("-REF")) {
      attribute_names[find(attributes, "IDENTIFIER")] = find(attributes, "LONG-NAME");
    } else if (element.starts_with("ATTRIBUTE-VALUE-")) {
      value_ = to_line(find(attributes, "THE-VALUE"));
      definition_.clear();
    } else if (element == "THE-VALUE") {
      formatted_ = 1;
      take_text();
    } else if (element == "SPEC-HIERARCHY") {
      places.push_back({open_places_.empty() ? kNone : open_places_.back(), ""});
      open_places_.push_back(places.size() - 1);
    } else if (element.ends_with("-REF")) {
      take_text();
    }
  }

  void end(std::string_view element) {
    if (stack_.empty()) return;  // the last call of a parser that was stopped
    stack_.pop_back();
    if (formatted_ > 1) {
      --formatted_;
      return;
    }
    if (element == "THE-VALUE") {
      formatted_ = 0;
      value_ = to_line(text_);
    } else if (element == "SPEC-HIERARCHY" && !open_places_.empty()) {
      open_places_.pop_back();
    } else if (element == "SPEC-OBJECT-REF" && !open_places_.empty() && !stack_.empty() && stack_.back() == "OBJECT") {
      places[open_places_.back()].object = to_line(text_);
    } else if (element.starts_with("ATTRIBUTE-DEFINITION-") && element.ends_with("-REF")) {
      definition_ = to_line(text_);
    } else if (element.starts_with("ATTRIBUTE-VALUE-") && is_in_object()) {
      objects.back().values[definition_] = value_;
    }
    takes_text_ = false;
  }

  // The values of an object, not those of a specification or a relation.
  bool is_in_object() const {
    return stack_.size() >= 2 && stack_.back() == "VALUES" && stack_[stack_.size() - 2] == "SPEC-OBJECT";
  }
  void take_text() {
    text_.clear();
    takes_text_ = true;
  }

  std::vector<std::string> stack_;
  std::vector<std::size_t> open_places_;
  std::size_t formatted_ = 0;  // elements that are open from THE-VALUE on
  bool takes_text_ = false;
  std::string text_, value_, definition_;
};

// The value of the first attribute of these names.
std::string get(const Object& object, const std::map<std::string, std::string>& attribute_names,
                const std::string& given, const std::vector<std::string>& usual) {
  std::vector<std::string> ids, names;
  for (const auto& [id, value] : object.values)
    if (const auto name = attribute_names.find(id); name != attribute_names.end()) {
      ids.push_back(id);
      names.push_back(name->second);
    }
  const std::size_t at = find_attribute(names, given, usual);
  return at == names.size() ? "" : object.values.at(ids[at]);
}

std::string get_id(const Object& object, const Reader& reader, const AttributeNames& names) {
  const std::string id = get(object, reader.attribute_names, names.id, kUsualIds);
  return !id.empty() ? id : !object.name.empty() ? object.name : object.id;
}

}  // namespace

std::vector<ListedRequirement> read_reqif(const std::string& text, const AttributeNames& names) {
  if (text.size() > kMaxText) throw RequirementError("more than 64 MB");
  if (text.starts_with("PK")) throw RequirementError("it is a .reqifz archive: unzip it, and import the .reqif in it");
  const std::unique_ptr<XML_ParserStruct, void (*)(XML_Parser)> parser(XML_ParserCreateNS(nullptr, '|'),
                                                                       XML_ParserFree);
  if (!parser) throw RequirementError("no memory to read it");
  Reader reader;
  reader.parser = parser.get();
  XML_SetUserData(parser.get(), &reader);
  XML_SetElementHandler(parser.get(), &Reader::begin, &Reader::end);
  XML_SetCharacterDataHandler(parser.get(), &Reader::text);
  XML_SetStartDoctypeDeclHandler(parser.get(), &Reader::refuse_types);
  const bool read = XML_Parse(parser.get(), text.data(), static_cast<int>(text.size()), 1) == XML_STATUS_OK;
  const std::string line = "line " + std::to_string(XML_GetCurrentLineNumber(parser.get())) + ": ";
  if (!reader.failure.empty()) throw RequirementError(line + reader.failure);
  if (!read) throw RequirementError(line + XML_ErrorString(XML_GetErrorCode(parser.get())));
  if (!reader.is_reqif) throw RequirementError("its root is not REQ-IF");

  for (const Object& object : reader.objects)
    for (const auto& [definition, value] : object.values)
      if (!reader.attribute_names.contains(definition))
        throw RequirementError("object '" + (object.name.empty() ? object.id : object.name) +
                               "' has a value of the attribute '" + definition + "', which the file does not define");
  std::map<std::string, std::string> ids;  // of requirements, by those of objects
  for (const Object& object : reader.objects) ids[object.id] = get_id(object, reader, names);
  std::map<std::string, std::string> parents;  // by the identifiers of objects
  for (const Place& place : reader.places)
    if (place.above != kNone) parents.emplace(place.object, reader.places[place.above].object);

  std::vector<ListedRequirement> list;
  for (const Object& object : reader.objects) {
    ListedRequirement one{ids.at(object.id), get(object, reader.attribute_names, names.text, kUsualTexts),
                          get(object, reader.attribute_names, names.parent, kUsualParents),
                          get(object, reader.attribute_names, names.rationale, kUsualRationales), ""};
    if (one.text.empty()) continue;  // a heading
    if (const auto above = parents.find(object.id); one.parent.empty() && above != parents.end())
      if (const auto id = ids.find(above->second); id != ids.end()) one.parent = id->second;
    list.push_back(std::move(one));
  }
  return list;
}

}  // namespace unlatch::tools
