#!/usr/bin/env python3
"""Doxygen's input filter: turns the plain comments of a header into Doxygen's, so that headers need no markup.

    comments.py FILE        writes the filtered header to standard output

Rules, all by position:

- The comment at the top of the file describes the file.
- A comment directly above a declaration describes it. Above a function or variable it also describes those that follow
  it, up to the next blank line or comment: a group of like functions needs one comment.
- A comment behind a member or function describes it; lines below it that begin in the same column continue it. Behind
  several names it describes each; if it is a list of as many units, each gets its own.
- A comment behind an opening brace, or behind a type on one line, describes the class or enumeration.
- A comment with a blank line below it, and a ruler (`// --- Bodies ---`), describe nothing.
- Lines indented by three or more spaces are shown as they are written: tables, drawings, formulas.
"""
import re
import sys

SCOPE = re.compile(r"^\s*(?:template\s*<.*>\s*)?(?:inline\s+)?(namespace|class|struct|union|enum)\b")
LABEL = re.compile(r"^\s*(public|private|protected):$")
RULER = re.compile(r"^-{3,}|-{6,}$")
LIST_ITEM = re.compile(r"^\s*(?:[-+*]|\d+\.)\s")
MOST_OF_A_UNIT = 14  # characters
DECLARATORS = re.compile(r"^(\s*)((?:[\w:]+(?:<[\w:<>, ]*>)?[ *&]+)+?)(\w+(?:\[\w+\])?(?:\s*=\s*[^,;]+)?(?:,\s*\w+(?:\[\w+\])?(?:\s*=\s*[^,;]+)?)+);$")


def split_comment(line):
    """(code, comment) of one line; comment is None without one. Strings and characters are skipped."""
    quote, i = "", 0
    while i < len(line):
        c = line[i]
        if quote:
            i += c == "\\"
            quote = "" if c == quote else quote
        elif c == "'" and i > 0 and line[i - 1].isalnum():
            pass  # 1'000
        elif c in "\"'":
            quote = c
        elif line.startswith("//", i):
            return line[:i].rstrip(), line[i + 2:]
        i += 1
    return line.rstrip(), None


def escape(text):
    """Doxygen's special characters as themselves, but for code between backticks."""
    parts = text.split("`")
    for i in range(0, len(parts), 2):
        parts[i] = re.sub(r"([\\@<>#%])", r"\\\1", parts[i])
    return "`".join(parts) if len(parts) % 2 else re.sub(r"([\\@<>#%`])", r"\\\1", text)


def mark_shown(lines):
    """(line, shown as written) of each comment line (without `//`); lists are not shown as written."""
    shown = False
    for line in lines:
        if line.strip():
            shown = len(line) - len(line.lstrip()) >= 3 and (shown or not LIST_ITEM.match(line))
        yield line, shown


def to_block(lines):
    """Comment lines as a block of Doxygen's. As many lines as before: Doxygen's places are the header's."""
    out, verbatim = [], False
    for line, shown in mark_shown(lines):
        if verbatim and not shown:
            out[-1] += " @endverbatim"
        text = line if shown else escape(line).strip().replace("*/", "* /")
        if shown and not verbatim:  # the line above takes the command: what follows it on its line would lose its indentation
            out = out or [""]
            out[-1] += " @verbatim"
        out.append(text)
        verbatim = shown
    out = out if len(out) == len(lines) else [" ".join(out[:2])] + out[2:]
    out[0] = f"/** {out[0]}"
    out[-1] += " @endverbatim */" if verbatim else " */"
    return out


def to_one_line(lines, mark):
    """The same within a line of code. What is shown as written is left out."""
    text = " ".join(escape(line).strip() for line, shown in mark_shown(lines) if not shown)
    return f"{mark} {text.replace('*/', '* /')} */" if text else ""


def split_declarators(code):
    """`double a, b = 0;` as one declaration each; others as they are."""
    match = DECLARATORS.match(code)
    if not match or re.search(r"\([^()]*,", code) or match[2].split()[0] in ("return", "using", "friend", "template"):
        return [code]
    return [f"{match[1]}{match[2].rstrip()} {name.strip()};" for name in match[3].split(",")]


def share_out(behind, count):
    """The comment behind `count` names, for each of them: its own unit, or else the whole."""
    if count > 1 and len(behind) == 1:
        for separator in ("; ", ", "):
            parts = behind[0].strip().split(separator)
            if len(parts) == count and all(len(part) <= MOST_OF_A_UNIT for part in parts):
                return [[f" {part}"] for part in parts]
    return [behind] * count


class Filter:
    def __init__(self, text):
        self.lines = text.split("\n")
        self.out = []
        self.scopes = []      # kinds of the open braces: namespace, class, enum, or "" for a body
        self.open = False     # within a declaration that has not ended
        self.round = 0        # open parentheses
        self.pending = []     # the comment directly above
        self.group = []       # the comment that describes further declarations
        self.opening = ""     # what the declaration so far would open: "class", …

    def run(self):
        i = self.write_file_comment()
        while i < len(self.lines):
            i = self.take(i)
        return "\n".join(self.out)

    def write_file_comment(self):
        i = 0
        while i < len(self.lines) and self.lines[i].startswith("//"):
            i += 1
        if i == 0 or not self.lines[i].startswith("#pragma once"):
            self.out += self.lines[:i]
            return i
        block = to_block([line[2:] for line in self.lines[:i]])
        self.out += block[:-1] + [block[-1].removesuffix("*/"), "@file */"]
        return i + 1

    def describes(self):
        """True where declarations have descriptions: not within bodies and parentheses."""
        return "" not in self.scopes and self.round == 0

    def take(self, i):
        line = self.lines[i]
        code, comment = split_comment(line)
        if not self.describes():
            self.put(code if comment is None else line)
            self.follow(code)
        elif not code.strip() and comment is None:  # blank
            self.flush()
            self.group = []
            self.put("")
        elif not code.strip():
            if RULER.search(comment.strip()):
                self.flush()
                self.put(line)
            else:
                self.pending.append(comment)
            self.group = [] if not self.open else self.group
        elif code.lstrip().startswith("#"):
            self.flush()
            self.put(line)
        else:
            return self.take_declaration(i, code, comment)
        return i + 1

    def take_declaration(self, i, code, comment):
        behind, first = [], i
        if comment is not None:
            behind.append(comment)
            column = len(self.lines[i]) - len(comment) - 2
            while i + 1 < len(self.lines) and re.match(rf"^ {{{column}}}//", self.lines[i + 1]):
                i += 1
                behind.append(self.lines[i][column + 2:])
        begins = not self.open
        is_namespace = code.lstrip().startswith("namespace")
        opens = SCOPE.match(code) is not None and code.rstrip().endswith("{")
        complete = SCOPE.match(code) is not None and code.rstrip().endswith("};")  # enum class Kind { kA, kB };
        if begins and (opens or complete) and behind and not is_namespace:
            code = f"{to_one_line(self.pending + behind, '/**')} {code.lstrip()}"
            self.out += [""] * len(self.pending)
            self.pending, behind = [], []
        closes_scope = code.lstrip().startswith("}")
        label = LABEL.match(code)
        if begins and not closes_scope and not label and not is_namespace:
            if self.pending:
                self.group = self.pending
                self.out += to_block(self.group)
            elif self.group and not behind:
                code = f"{to_one_line(self.group, '/**')} {code.lstrip()}"
            self.pending = []
        elif self.pending:
            self.flush()
        names = split_declarators(code) if begins and self.scopes[-1:] in (["class"], ["struct"], ["union"]) else [code]
        if closes_scope and code.strip() == "}":  # of a namespace
            self.put(code)
        elif len(names) > 1:
            shared = share_out(behind, len(names))
            above = "" if behind else to_one_line(self.group, "/**")  # the first name has it already
            self.put(above.join(f" {one} {to_one_line(own, '/**<')}" for one, own in zip(names, shared)))
            self.out += [""] * (len(behind) - 1)
        else:
            self.put(f"{code}  {to_one_line(behind, '/**<')}" if behind else code)
            self.out += [""] * (len(behind) - 1)
        self.follow(split_comment(self.lines[first])[0])
        if SCOPE.match(code) or closes_scope:
            self.group = []
        return i + 1

    def put(self, line):
        self.out.append(line)

    def flush(self):
        """A comment that describes nothing stays what it was."""
        self.out += ["//" + line for line in self.pending]
        self.pending = []

    def follow(self, code):
        """Keeps track of braces, parentheses and the ends of declarations."""
        text = re.sub(r"\"(?:\\.|[^\"\\])*\"|(?<!\w)'(?:\\.|[^'\\])'", "", code).strip()
        match = SCOPE.match(text)
        if match and not self.open:
            self.opening = match[1]
        for c in text:
            if c in "()":
                self.round += 1 if c == "(" else -1
            elif c == "{":
                self.scopes.append("" if self.round > 0 else self.opening)
                self.opening = ""
            elif c == "}":
                self.scopes = self.scopes[:-1]
            elif c == ";" and self.describes():
                self.opening = ""
        if text and self.describes():
            self.open = not (text.endswith((";", "{", "}")) or LABEL.match(text) or self.scopes[-1:] == ["enum"])


if __name__ == "__main__":
    with open(sys.argv[1], encoding="utf-8") as file:
        sys.stdout.write(Filter(file.read()).run())
