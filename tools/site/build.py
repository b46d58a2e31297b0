#!/usr/bin/env python3
"""The documentation site from the Markdown of the repository: build.py WORK OUT

Copies every page and picture into WORK, in the same folders, so that their links hold; makes a page of each other file that a page links to,
and of the C header and the Python package; runs MkDocs into OUT. Exit code 1, with the place, if a link leads nowhere, or a function of the C header
or a name of the Python package has no description.
"""
import ast
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BLOCK = re.compile(r"^(?P<indent> *)```(?P<info>[^\n]*)\n(?P<body>.*?)^ *```$", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"(?P<head>!?\[(?:[^\[\]]|\[[^\]]*\])*\])\((?P<target>[^)\s]+)\)")
PICTURES = (".svg", ".png", ".jpg")
LANGUAGES = {".py": "python", ".yaml": "yaml", ".h": "cpp", ".cc": "cpp", ".c": "c", ".json": "json", ".sh": "bash", ".idl": "idl", ".lcm": "c", ".mjs": "js"}
MOST_SHOWN = 60_000  # bytes of a file that is shown as a page; larger ones are data
NOT_PAGES = (".github/", "tests/fuzz/corpus", "build/")


def list_files(*patterns):
    listed = subprocess.run(["git", "-C", ROOT, "ls-files", "-z", "--cached", "--others", "--exclude-standard", *patterns],
                            capture_output=True, check=True).stdout.decode()
    return sorted(name for name in listed.split("\0") if name and (ROOT / name).is_file() and not name.startswith(NOT_PAGES))


class Stage:
    def __init__(self, folder):
        self.folder = folder
        self.pages = set(list_files("*.md"))
        self.shown = {}  # files that pages link to, by their page
        self.faults = []

    def write(self, name, text):
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")

    def copy(self, name):
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(ROOT / name, path)

    def follow(self, page, match):
        """Returns the link as the site needs it."""
        head, target = match["head"], match["target"]
        if re.match(r"[a-z]+:", target) or target.startswith("#"):
            return match[0]
        path, _, anchor = target.partition("#")
        there = os.path.normpath(os.path.join(os.path.dirname(page), path))
        if (ROOT / there).is_dir():
            there = os.path.join(there, "README.md")
            if there not in self.pages:
                return head[1:-1]  # a folder without a page
        if not (ROOT / there).is_file() or there.startswith(".."):
            self.faults.append(f"{page}: a link to {target}, which is not there")
            return match[0]
        if there in self.pages:
            name = there
        elif there.endswith(PICTURES):
            self.copy(there)
            name = there
        elif (ROOT / there).stat().st_size > MOST_SHOWN or b"\0" in (ROOT / there).read_bytes()[:1000]:
            return head[1:-1]
        else:
            name = self.shown[there] = there + ".md"
        return f"{head}({os.path.relpath(name, os.path.dirname(page) or '.')}{'#' + anchor if anchor else ''})"

    def convert(self, page, text):
        """Returns the page as Python-Markdown needs it: blocks with a language alone, an empty line before each list, lists in steps of four spaces."""
        out, at = [], 0
        for block in BLOCK.finditer(text):
            out += [self.convert_text(page, text[at:block.start()]), self.convert_block(block)]
            at = block.end()
        return "".join(out + [self.convert_text(page, text[at:])])

    @staticmethod
    def convert_block(block):
        language = (block["info"].split() or [""])[0]
        indent = " " * (4 if block["indent"] else 0)
        lines = [line[len(block["indent"]):] if line.startswith(block["indent"]) else line for line in block["body"].splitlines()]
        return "\n".join([f"{indent}```{language}", *((indent + line).rstrip() for line in lines), f"{indent}```"])

    def convert_text(self, page, text):
        lines, before = [], ""
        for line in text.split("\n"):
            item = re.match(r"( *)(?:[-*]|\d+\.) ", line)
            listed = re.match(r" *(?:[-*]|\d+\.) |  ", before)
            if item and before.strip() and not listed:
                lines.append("")
            nested = re.match(r" {2,3}(?=\S)", line) if listed or item else None
            lines.append("    " + line.lstrip() if nested else line)
            before = line
        return LINK.sub(lambda match: self.follow(page, match), "\n".join(lines))

    def stage(self):
        for page in sorted(self.pages):
            self.write(page, self.convert(page, (ROOT / page).read_text(encoding="utf-8")))
        for file, page in self.shown.items():
            text = (ROOT / file).read_text(encoding="utf-8", errors="replace")
            language = LANGUAGES.get(Path(file).suffix, "text" if not text.startswith("#!") else "python" if "python" in text[:40] else "bash")
            self.write(page, f"# {file}\n\n````{language}\n{text}\n````\n")


def describe_header(faults):
    """The C header as a page: each of its sections with a heading. A comment describes the functions below it, up to the next blank line."""
    text = (ROOT / "library/include/unlatch.h").read_text(encoding="utf-8")
    for paragraph in re.split(r"\n\s*\n", text):
        for match in re.finditer(r"UNLATCH_API [^;(]*?(unlatch_\w+)\(", paragraph):
            if "/*" not in paragraph[:match.start()]:
                faults.append(f"library/include/unlatch.h: {match[1]} has no description")
    parts = re.split(r"^/\* --- (.+?) -+ \*/$", text, flags=re.MULTILINE)
    out = ["# C: unlatch.h", "", "The whole of the public header [library/include/unlatch.h](../library/include/unlatch.h.md), by its sections. [The library](../library/README.md) has examples.", "",
           "```c", parts[0].strip(), "```"]
    for title, body in zip(parts[1::2], parts[2::2]):
        out += ["", f"## {title.strip()}", "", "```c", body.strip(), "```"]
    return "\n".join(out) + "\n"


class PythonReference:
    """Public classes, functions and methods of the Python package with their signatures and descriptions."""

    def __init__(self):
        self.faults = []
        self.names = ast.literal_eval(re.search(r"^__all__ = (\[.*?\])", (ROOT / "library/python/unlatch/__init__.py").read_text(), re.M | re.S)[1])

    def describe(self, node, where, inherited=False):
        text = ast.get_docstring(node)
        if not text and not inherited:
            self.faults.append(f"{where}:{node.lineno}: {node.name} has no description")
        return [text.replace("<", "&lt;"), ""] if text else []

    @staticmethod
    def write_signature(node):
        returns = f" -> {ast.unparse(node.returns)}" if node.returns else ""
        return f"{node.name}({ast.unparse(node.args)}){returns}"

    def write(self):
        package = ROOT / "library/python/unlatch"
        introduction = ast.get_docstring(ast.parse((package / "__init__.py").read_text(encoding="utf-8")))
        out = ["# Python: the package unlatch", "", *introduction.replace("<", "&lt;").splitlines(), ""]
        for path in sorted(package.glob("*.py")):
            where = path.relative_to(ROOT)
            for node in ast.parse(path.read_text(encoding="utf-8")).body:
                if getattr(node, "name", None) not in self.names:
                    continue
                if isinstance(node, ast.FunctionDef):
                    out += [f"## {node.name}", "", "```python", self.write_signature(node), "```", "", *self.describe(node, where)]
                elif isinstance(node, ast.ClassDef):
                    out += self.write_class(node, where)
        return "\n".join(out) + "\n"

    def write_class(self, node, where):
        bases = ", ".join(ast.unparse(base) for base in node.bases)
        out = [f"## {node.name}", "", *(["```python", f"class {node.name}({bases})", "```", ""] if bases else []), *self.describe(node, where)]
        fields = [f"{ast.unparse(item.target)}: {ast.unparse(item.annotation)}" for item in node.body if isinstance(item, ast.AnnAssign) and not item.target.id.startswith("_")]
        if fields:
            out += ["```python", *fields, "```", ""]
        for item in node.body:
            if isinstance(item, ast.FunctionDef) and not item.name.startswith("_"):
                kinds = {ast.unparse(mark) for mark in item.decorator_list}
                if any("setter" in kind or "overload" in kind for kind in kinds):
                    continue
                returns = f": {ast.unparse(item.returns)}" if item.returns else ""
                signature = f"{item.name}{returns}" if "property" in kinds else self.write_signature(item)
                inherited = any(base in bases for base in ("Mapping", "Sequence", "ABC"))
                out += [f"### {node.name}.{item.name}", "", "```python", signature, "```", "", *self.describe(item, where, inherited)]
        return out


def write_search(out, shown):
    """One script with the index and the worker, since a page that is opened as a file may read neither."""
    index = json.loads((out / "search/search_index.json").read_text(encoding="utf-8"))
    files = {name.removesuffix(".md") + ".html" for name in shown}  # sources are read through links, not found among the pages
    index["docs"] = [entry for entry in index["docs"] if entry["location"].partition("#")[0] not in files]
    (worker,) = (out / "assets/javascripts/workers").glob("search.*.min.js")
    script = (f"var __search = {{ index: Promise.resolve({json.dumps(index)}),\n"
              f"  worker: URL.createObjectURL(new Blob([{json.dumps(worker.read_text(encoding='utf-8'))}], {{ type: 'text/javascript' }})) }};\n")
    (out / "search.js").write_text(script, encoding="utf-8")


def main():
    work, out = (Path(argument).resolve() for argument in sys.argv[1:3])
    shutil.rmtree(work, ignore_errors=True)
    stage = Stage(work / "pages")
    stage.stage()
    stage.shown["library/include/unlatch.h"] = "library/include/unlatch.h.md"
    stage.stage()
    shutil.copyfile(ROOT / "tools/site/site.css", stage.folder / "site.css")
    python = PythonReference()
    stage.write("reference/c.md", describe_header(stage.faults))
    stage.write("reference/python.md", python.write())
    stage.write("reference/cpp.md", "# C++\n\nThe classes and functions of the kernel's public headers, with an example: [open the C++ reference](../cpp/index.html). It has a search of its own.\n")
    # The site begins with START.md; README.md would be the index of the same folder.
    (stage.folder / "START.md").rename(stage.folder / "index.md")
    (stage.folder / "README.md").rename(stage.folder / "overview.md")
    renamed = {"START.md": "index.md", "README.md": "overview.md"}
    for path in stage.folder.rglob("*.md"):
        depth = os.path.relpath(stage.folder, path.parent)
        text = path.read_text(encoding="utf-8")
        for old, new in renamed.items():
            before = old if depth == "." else f"{depth}/{old}"
            text = re.sub(rf"\]\({re.escape(before)}(?=[#)])", f"]({new if depth == '.' else f'{depth}/{new}'}", text)
        path.write_text(text, encoding="utf-8")
    settings = (ROOT / "tools/site/mkdocs.yml").read_text(encoding="utf-8").replace(": START.md", ": index.md").replace(": README.md", ": overview.md")
    settings = settings.replace("  name: material\n", f"  name: material\n  custom_dir: {ROOT / 'tools/site/theme'}\n")
    (work / "mkdocs.yml").write_text(f"docs_dir: {stage.folder}\nsite_dir: {out}\n{settings}", encoding="utf-8")
    program = shutil.which("mkdocs", path="/usr/bin:" + os.environ["PATH"])
    done = subprocess.run([program, "build", "-q", "-f", work / "mkdocs.yml"], env={**os.environ, "PYTHONPATH": str(ROOT / "tools/site"), "PYTHONDONTWRITEBYTECODE": "1"},
                          capture_output=True, text=True, check=False)
    warnings = [line for line in done.stderr.splitlines() if line.startswith(("WARNING", "ERROR"))]
    faults = list(dict.fromkeys(stage.faults + python.faults + warnings))  # pages are staged twice
    if done.returncode == 0:
        write_search(out, stage.shown.values())
    else:
        faults.append(done.stderr[-2000:])
    for fault in faults:
        print(fault, file=sys.stderr)
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
