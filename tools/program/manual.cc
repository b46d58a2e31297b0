#include "tools/program/manual.h"

namespace unlatch::tools {
namespace {

// A code point of UTF-8 that begins at `i`, which moves behind it.
unsigned decode(const std::string& text, std::size_t& i) {
  const auto next = [&] { return static_cast<unsigned char>(text[i++]); };
  const unsigned first = next();
  if (first < 0x80) return first;
  const int more = first >= 0xf0 ? 3 : first >= 0xe0 ? 2 : 1;
  unsigned code = first & (0x3fU >> more);
  for (int k = 0; k < more && i < text.size(); ++k) code = code << 6 | (next() & 0x3fU);
  return code;
}

// Text that roff prints as it stands.
std::string escape(const std::string& text) {
  std::string roff;
  bool line_begins = true;
  for (std::size_t i = 0; i < text.size();) {
    const unsigned code = decode(text, i);
    if (line_begins && (code == '.' || code == '\'')) roff += "\\&";
    line_begins = code == '\n';
    if (code >= 0x80) {
      char name[16];
      std::snprintf(name, sizeof name, "\\[u%04X]", code);
      roff += name;
    } else if (code == '\\') {
      roff += "\\e";
    } else if (code == '-') {
      roff += "\\-";
    } else {
      roff += static_cast<char>(code);
    }
  }
  return roff;
}

std::string in_bold(const std::string& text) { return "\\fB" + escape(text) + "\\fR"; }
std::string in_italics(const std::string& text) { return "\\fI" + escape(text) + "\\fR"; }

// One sentence a line, as manual pages are written.
std::string build_paragraph(const std::string& text) {
  std::string lines = escape(text);
  for (std::size_t at = 0; (at = lines.find(". ", at)) != std::string::npos; ++at) lines.replace(at, 2, ".\n");
  return lines + "\n";
}

std::string build_synopsis(const std::string& name, const Command& command) {
  std::string line = ".B " + escape(name) + "\n[\\fIoption\\fR]...";
  for (const OptionText& option : command.list_options()) {
    if (option.is_argument) line += " " + in_italics(option.names[0]) + (option.is_repeatable ? "..." : "");
  }
  if (!command.list_verbs().empty()) line = ".B " + escape(name) + "\n\\fIverb\\fR [\\fIoption\\fR]...";
  return line + "\n";
}

std::string build_option(const OptionText& option) {
  std::string head;
  for (const std::string& name : option.names)
    head += (head.empty() ? "" : ", ") + (option.is_argument ? in_italics(name) : in_bold(name));
  if (!option.value.empty()) head += " " + in_italics(option.value);
  const std::string required = option.is_required ? " Required." : "";
  std::string text = option.description;
  if (!required.empty() && !text.empty() && text.back() != '.') text += '.';
  return ".TP\n" + head + "\n" + build_paragraph(text + required);
}

std::string build_examples(const Command& command) {
  std::string lines;
  for (const std::string& line : command.list_footer()) {
    if (line.starts_with("  ")) lines += escape(line.substr(2)) + "\n";
  }
  return lines.empty() ? "" : ".SH EXAMPLES\n.nf\n" + lines + ".fi\n";
}

std::string build_verb_list(const Command& app) {
  std::string text = ".SH VERBS\n";
  for (const Command& verb : app.list_verbs()) {
    text += ".TP\n.BR unlatch\\-" + escape(verb.get_name()) + " (1)\n" + escape(verb.get_summary()) + ".\n";
  }
  return text;
}

}  // namespace

std::string build_manual(const Command& app, const Command* verb) {
  const Command& command = verb != nullptr ? *verb : app;
  const std::string name = verb != nullptr ? app.get_name() + " " + verb->get_name() : app.get_name();
  const std::string page = verb != nullptr ? app.get_name() + "-" + verb->get_name() : app.get_name();
  std::string upper = page;
  for (char& c : upper) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));

  std::string text = ".TH " + escape(upper) + " 1 \"\" \"unlatch " UNLATCH_VERSION "\" \"unlatch\"\n";
  text += ".SH NAME\n" + escape(page) + " \\- " + escape(command.get_summary()) + "\n";
  text += ".SH SYNOPSIS\n" + build_synopsis(name, command);
  text += ".SH DESCRIPTION\n" + build_paragraph(command.get_description());
  if (!command.list_verbs().empty()) text += build_verb_list(command);
  text += ".SH OPTIONS\n";
  for (const OptionText& option : command.list_options()) text += build_option(option);
  text += ".SH EXIT STATUS\n" + build_paragraph(kExitCodesText);
  text += ".SH ENVIRONMENT\n.TP\n.B NO_COLOR\nif set, no colours; without a terminal there are none anyway\n";
  text += build_examples(command);
  if (verb != nullptr) text += ".SH SEE ALSO\n.BR " + escape(app.get_name()) + " (1)\n";
  return text;
}

}  // namespace unlatch::tools
