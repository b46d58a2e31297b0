#include "bridge/telemetry/xtce.h"

#include <algorithm>
#include <cctype>
#include <set>

#include "bridge/telemetry/message_fields.h"
#include "bridge/telemetry/space_packets.h"
#include "hil/scenario/text/xml_text.h"

namespace unlatch::bridge {
namespace {

using hil::CatalogKind;
using hil::MessageKind;

std::string escape(std::string_view text) { return hil::escape_xml(std::string(text)); }

// Names of XTCE have no '.', '/', ':' and no blanks.
std::string to_name(std::string_view text) {
  std::string out;
  for (const char c : text) out += std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '_' ? c : '_';
  return out;
}

std::string attribute(const char* key, std::string_view value) {
  return std::string(" ") + key + "=\"" + escape(value) + "\"";
}

class Writer {
 public:
  explicit Writer(const SessionLayout& layout) : layout_(layout) {}

  std::string write() {
    add_header();
    for (std::size_t i = 0; i < hil::kMessageKinds; ++i) {
      const auto kind = static_cast<MessageKind>(i);
      if (!is_sent(kind)) continue;
      if (kind == MessageKind::kState)
        for (int part = 0; part < std::min(layout_.count_state_parts(), kMostStateParts); ++part)
          add_packet(kind, part);
      else if (kind == MessageKind::kReactions)
        for (int part = 0; part < std::min(layout_.count_reaction_parts(), kMostReactionParts); ++part)
          add_packet(kind, part);
      else
        add_packet(kind, 0);
    }
    return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<SpaceSystem xmlns=\"http://www.omg.org/spec/XTCE/20180204\"" +
           attribute("name", to_name(layout_.get_scenario())) +
           attribute("shortDescription", "unlatch: packets of the scenario " + layout_.get_scenario()) +
           ">\n  <TelemetryMetaData>\n    <ParameterTypeSet>\n" + types_ +
           "    </ParameterTypeSet>\n    <ParameterSet>\n" + parameters_ + "    </ParameterSet>\n    <ContainerSet>\n" +
           containers_ + "    </ContainerSet>\n  </TelemetryMetaData>\n</SpaceSystem>\n";
  }

 private:
  void add_type(const std::string& name, const std::string& element, const std::string& attributes,
                const std::string& inside) {
    if (!names_of_types_.insert(name).second) return;
    types_ += "      <" + element + attribute("name", name) + attributes + ">" + inside + "</" + element + ">\n";
  }
  // The unit of a field as the schema has it; none where it says in words whose it is: "the channel's unit".
  static std::string get_unit(const MessageField& field) {
    return field.unit.starts_with("the ") ? "" : std::string(field.unit);
  }
  static std::string describe(const MessageField& field) {
    return std::string(field.comment) +
           (!field.unit.starts_with("the ") ? "" : (field.comment.empty() ? "in " : ", in ") + std::string(field.unit));
  }
  static std::string write_unit(std::string_view unit) {
    return unit.empty() || unit == "1" ? "<UnitSet/>" : "<UnitSet><Unit>" + escape(unit) + "</Unit></UnitSet>";
  }
  static std::string write_integer(int bits, bool is_signed) {
    return "<IntegerDataEncoding" + attribute("sizeInBits", std::to_string(bits)) +
           attribute("encoding", is_signed ? "twosComplement" : "unsigned") + "/>";
  }

  std::string add_unsigned(int bits) {
    const std::string name = "uint" + std::to_string(bits);
    add_type(name, "IntegerParameterType",
             attribute("signed", "false") + attribute("sizeInBits", bits > 32 ? "64" : "32"),
             "<UnitSet/>" + write_integer(bits, false));
    return name;
  }

  // Type of a number of this field; `unit`: that of the field, or of the item of the catalog.
  std::string add_type_of(const MessageField& field, const std::string& unit) {
    const std::string of_unit = unit.empty() || unit == "1" ? "" : "_" + to_name(unit);
    if (!field.enumeration.empty()) return add_enumeration(field.enumeration);
    if (field.type == FieldType::kOctet && field.count == 1) return add_unsigned(8);
    if (field.type == FieldType::kOctet) {
      const std::string name = "text" + std::to_string(field.count);
      add_type(name, "StringParameterType", "",
               "<UnitSet/><StringDataEncoding encoding=\"UTF-8\"><SizeInBits><Fixed><FixedValue>" +
                   std::to_string(8 * field.count) +
                   "</FixedValue></Fixed><TerminationChar>00</TerminationChar></SizeInBits></StringDataEncoding>");
      return name;
    }
    if (field.type == FieldType::kDouble) {
      add_type("double" + of_unit, "FloatParameterType", attribute("sizeInBits", "64"),
               write_unit(unit) + "<FloatDataEncoding sizeInBits=\"64\" encoding=\"IEEE754_1985\"/>");
      return "double" + of_unit;
    }
    const int bits = field.type == FieldType::kInt64 ? 64 : 32;
    const std::string name = "int" + std::to_string(bits) + of_unit;
    add_type(name, "IntegerParameterType", attribute("signed", "true") + attribute("sizeInBits", std::to_string(bits)),
             write_unit(unit) + write_integer(bits, true));
    return name;
  }

  std::string add_enumeration(std::string_view of) {
    std::string list;
    for (const EnumTexts& texts : kEnums)
      for (int value = 0; texts.name == of && value < texts.count; ++value)
        list += "<Enumeration" + attribute("value", std::to_string(value)) + attribute("label", texts.get_text(value)) +
                "/>";
    add_type(std::string(of), "EnumeratedParameterType", "",
             "<UnitSet/>" + write_integer(32, true) + "<EnumerationList>" + list + "</EnumerationList>");
    return std::string(of);
  }

  // A number, or an enumeration of the joint's modes where their names are known.
  std::string add_modes(std::size_t joint) {
    const std::vector<std::string>& modes = layout_.get_modes(joint);
    if (modes.empty()) return add_unsigned(8);
    std::string list;
    for (std::size_t i = 0; i < modes.size(); ++i)
      list += "<Enumeration" + attribute("value", std::to_string(i)) + attribute("label", modes[i]) + "/>";
    const std::string name = "modes_of_joint" + std::to_string(joint);
    add_type(name, "EnumeratedParameterType", "",
             "<UnitSet/>" + write_integer(8, false) + "<EnumerationList>" + list + "</EnumerationList>");
    return name;
  }

  // Adds a parameter to a container; `alias`: the name in unlatch, which may have dots.
  void add(std::string& container, const std::string& type, const std::string& alias, std::string_view comment) {
    std::string name = to_name(alias);
    while (!names_.insert(name).second) name += "_";
    parameters_ += "      <Parameter" + attribute("name", name) + attribute("parameterTypeRef", type) +
                   (comment.empty() ? "" : attribute("shortDescription", comment)) +
                   "><AliasSet><Alias nameSpace=\"unlatch\"" + attribute("alias", alias) +
                   "/></AliasSet></Parameter>\n";
    container += "          <ParameterRefEntry" + attribute("parameterRef", name) + "/>\n";
  }

  void add_header() {
    std::string entries;
    const auto add_bits = [&](const char* name, int bits, const char* comment) {
      add(entries, add_unsigned(bits), name, comment);
    };
    add_bits("ccsds_version", 3, "packet version number, 0");
    add_bits("ccsds_type", 1, "0: telemetry");
    add_bits("ccsds_secondary_header", 1, "1");
    add_bits("ccsds_apid", 11, "application process identifier: the kind of the packet");
    add_bits("ccsds_sequence_flags", 2, "3: unsegmented");
    add_bits("ccsds_sequence_count", 14, "counts the packets of this identifier");
    add_bits("ccsds_length", 16, "bytes behind the primary header, less 1");
    add(entries, "time_seconds", "time_seconds", "simulated time since the beginning of the run, whole seconds");
    add_type("time_seconds", "IntegerParameterType", attribute("signed", "false") + attribute("sizeInBits", "32"),
             "<UnitSet><Unit>s</Unit></UnitSet>" + write_integer(32, false));
    add(entries, "time_fraction", "time_fraction", "fraction of the second, in units of 2^-24 s");
    add_type("time_fraction", "IntegerParameterType", attribute("signed", "false") + attribute("sizeInBits", "32"),
             "<UnitSet/>" + write_integer(24, false));
    containers_ += "      <SequenceContainer name=\"SpacePacket\" abstract=\"true\">\n        <EntryList>\n" + entries +
                   "        </EntryList>\n      </SequenceContainer>\n";
  }

  void add_packet(MessageKind kind, int part) {
    const bool in_parts = kind == MessageKind::kState || kind == MessageKind::kReactions;
    const std::string name = std::string(hil::get_kind_name(kind)) + (in_parts && part > 0 ? std::to_string(part) : "");
    std::string entries;
    for (const MessageField& field : kMessageFields[static_cast<std::size_t>(kind)]) {
      if (in_parts && field.count > 1)
        add_array(entries, kind, field, part);
      else if (field.count > 1 && field.type != FieldType::kOctet)
        for (std::size_t i = 0; i < field.count; ++i)
          add(entries, add_type_of(with_count(field, 1), std::string(field.unit)),
              name + "." + std::string(field.name) + "." +
                  std::string(hil::get_text(static_cast<hil::Reject>(i))),  // the one such array: Health.rejected
              field.comment);
      else
        add(entries, add_type_of(field, get_unit(field)), name + "." + std::string(field.name), describe(field));
    }
    containers_ += "      <SequenceContainer" + attribute("name", name) + ">\n        <EntryList>\n" + entries +
                   "        </EntryList>\n        <BaseContainer containerRef=\"SpacePacket\"><RestrictionCriteria>"
                   "<Comparison parameterRef=\"ccsds_apid\"" +
                   attribute("value", std::to_string(get_apid(kind, part))) +
                   "/></RestrictionCriteria></BaseContainer>\n      </SequenceContainer>\n";
  }

  // An array of State or Reactions: the names are the catalog's.
  void add_array(std::string& entries, MessageKind kind, const MessageField& field, int part) {
    const std::size_t valid = layout_.count_valid(kind, field.name, part);
    const std::size_t first = static_cast<std::size_t>(part) * field.count;
    for (std::size_t i = 0; i < valid; ++i) {
      if (kind == MessageKind::kReactions) {
        static constexpr const char* kRows[] = {"x", "y", "z", "rot_x", "rot_y", "rot_z"};
        const std::size_t row = (first + i) % 6;
        add(entries, add_type_of(with_count(field, 1), row < 3 ? "N" : "N m"),
            layout_.list(CatalogKind::kJoint)[(first + i) / 6].name + ".reaction." + kRows[row], "");
      } else if (field.type == FieldType::kPart) {
        const std::string& body = layout_.list(CatalogKind::kBody)[first + i].name;
        for (const MessageField& own : field.parts)
          add(entries, add_type_of(own, std::string(own.unit)), body + "." + std::string(own.name), own.comment);
      } else if (field.type == FieldType::kOctet) {
        add(entries, add_modes(first + i), layout_.list(CatalogKind::kJoint)[first + i].name + ".mode",
            "index into the joint's list of modes");
      } else {
        const LayoutItem& sensor = layout_.list(CatalogKind::kSensor)[first + i];
        add(entries, add_type_of(with_count(field, 1), sensor.unit), "received." + sensor.name,
            "as flight software receives it");
      }
    }
  }

  static MessageField with_count(MessageField field, std::size_t count) {
    field.count = count;
    return field;
  }

  const SessionLayout& layout_;
  std::set<std::string> names_of_types_, names_;
  std::string types_, parameters_, containers_;
};

}  // namespace

std::string write_xtce(const SessionLayout& layout) { return Writer(layout).write(); }

}  // namespace unlatch::bridge
