#!/usr/bin/env python3
"""Requirements to ReqIF and CSV and back. ReqIF is read here by the rules of its schema (OMG formal/2016-07-01), with Python's
XML alone: nothing of the writer is shared.

    requirements_test.py BIN_FOLDER SOURCE_FOLDER [unittest options]
"""

import csv
import re
import xml.etree.ElementTree as ElementTree

import yaml
from processes import UNLATCH, ProcessTest, call, main

NS = "{http://www.omg.org/spec/ReqIF/20110401/reqif.xsd}"
XHTML = "{http://www.w3.org/1999/xhtml}"
TEXT = 'They keep "clear" & <safe>, naïvely'
SCENARIO = f"""unlatch: 1
name: pass
step: {{dt: 1 ms, until: 1}}
bodies:
  still: {{mass: 1, inertia: [1, 1, 1], shape: [{{sphere: {{radius: 0.25}}}}]}}
  moving: {{mass: 1, inertia: [1, 1, 1], position: [-1.2, 1, 0], velocity: [2, 0, 0], shape: [{{sphere: {{radius: 0.5}}}}]}}
events: [{{name: late, when: {{time: 0.4}}}}]
requirements:
  - {{id: near, text: '{TEXT}', parent: SYS-4, rationale: "a hand's width", clearance: [still, moving], at_least: 20 cm}}
  - {{id: nearer, text: a part of it, parent: near, clearance: [still, moving], at_least: 0.1}}
  - {{id: plain, time: {{event: late}}, range: [0.1, 1]}}
"""

# For each element: the attributes that it must have, those that it may have, and its elements with how often they may come.
IDENTIFIED = ({"IDENTIFIER", "LAST-CHANGE"}, {"LONG-NAME", "DESC"})
ONE, ANY = (1, 1), (0, 10**9)
MAYBE, SOME = (0, 1), (1, 10**9)
RULES = {
    "REQ-IF": ((set(), set()), {"THE-HEADER": ONE, "CORE-CONTENT": ONE, "TOOL-EXTENSIONS": MAYBE}),
    "THE-HEADER": ((set(), set()), {"REQ-IF-HEADER": ONE}),
    "REQ-IF-HEADER": (({"IDENTIFIER"}, set()), {"COMMENT": MAYBE, "CREATION-TIME": ONE, "REPOSITORY-ID": MAYBE, "REQ-IF-TOOL-ID": ONE, "REQ-IF-VERSION": ONE,
                                                "SOURCE-TOOL-ID": ONE, "TITLE": ONE}),
    "CORE-CONTENT": ((set(), set()), {"REQ-IF-CONTENT": ONE}),
    "REQ-IF-CONTENT": ((set(), set()), {"DATATYPES": MAYBE, "SPEC-TYPES": MAYBE, "SPEC-OBJECTS": MAYBE, "SPEC-RELATIONS": MAYBE, "SPECIFICATIONS": MAYBE}),
    "DATATYPES": ((set(), set()), {"DATATYPE-DEFINITION-STRING": ANY, "DATATYPE-DEFINITION-XHTML": ANY}),
    "DATATYPE-DEFINITION-STRING": ((IDENTIFIED[0] | {"MAX-LENGTH"}, IDENTIFIED[1]), {}),
    "DATATYPE-DEFINITION-XHTML": (IDENTIFIED, {}),
    "SPEC-TYPES": ((set(), set()), {"SPEC-OBJECT-TYPE": ANY, "SPECIFICATION-TYPE": ANY}),
    "SPEC-OBJECT-TYPE": (IDENTIFIED, {"SPEC-ATTRIBUTES": MAYBE}),
    "SPECIFICATION-TYPE": (IDENTIFIED, {"SPEC-ATTRIBUTES": MAYBE}),
    "SPEC-ATTRIBUTES": ((set(), set()), {"ATTRIBUTE-DEFINITION-STRING": ANY, "ATTRIBUTE-DEFINITION-XHTML": ANY}),
    "ATTRIBUTE-DEFINITION-STRING": (IDENTIFIED, {"TYPE": ONE}),
    "ATTRIBUTE-DEFINITION-XHTML": (IDENTIFIED, {"TYPE": ONE}),
    "SPEC-OBJECTS": ((set(), set()), {"SPEC-OBJECT": ANY}),
    "SPEC-OBJECT": (IDENTIFIED, {"VALUES": MAYBE, "TYPE": ONE}),
    "VALUES": ((set(), set()), {"ATTRIBUTE-VALUE-STRING": ANY, "ATTRIBUTE-VALUE-XHTML": ANY}),
    "ATTRIBUTE-VALUE-STRING": (({"THE-VALUE"}, set()), {"DEFINITION": ONE}),
    "ATTRIBUTE-VALUE-XHTML": ((set(), {"IS-SIMPLIFIED"}), {"DEFINITION": ONE, "THE-VALUE": ONE}),
    "SPECIFICATIONS": ((set(), set()), {"SPECIFICATION": ANY}),
    "SPECIFICATION": (IDENTIFIED, {"VALUES": MAYBE, "TYPE": ONE, "CHILDREN": MAYBE}),
    "CHILDREN": ((set(), set()), {"SPEC-HIERARCHY": ANY}),
    "SPEC-HIERARCHY": ((IDENTIFIED[0], IDENTIFIED[1] | {"IS-EDITABLE", "IS-TABLE-INTERNAL"}), {"OBJECT": ONE, "CHILDREN": MAYBE}),
    "OBJECT": ((set(), set()), {"SPEC-OBJECT-REF": ONE}),
}
# A reference names an element of this kind.
REFERENCES = {"DATATYPE-DEFINITION-STRING-REF": "DATATYPE-DEFINITION-STRING", "DATATYPE-DEFINITION-XHTML-REF": "DATATYPE-DEFINITION-XHTML",
              "ATTRIBUTE-DEFINITION-STRING-REF": "ATTRIBUTE-DEFINITION-STRING", "ATTRIBUTE-DEFINITION-XHTML-REF": "ATTRIBUTE-DEFINITION-XHTML",
              "SPEC-OBJECT-TYPE-REF": "SPEC-OBJECT-TYPE", "SPECIFICATION-TYPE-REF": "SPECIFICATION-TYPE", "SPEC-OBJECT-REF": "SPEC-OBJECT"}
HOLDERS = {"TYPE", "DEFINITION"}  # hold one reference

# What DOORS and others write: prefixes, headings, formatted text, values before their definition, children before the object.
FOREIGN = """<?xml version="1.0" encoding="UTF-8"?>
<reqif:REQ-IF xmlns:reqif="http://www.omg.org/spec/ReqIF/20110401/reqif.xsd" xmlns:h="http://www.w3.org/1999/xhtml">
 <reqif:CORE-CONTENT><reqif:REQ-IF-CONTENT>
  <reqif:SPEC-TYPES><reqif:SPEC-OBJECT-TYPE IDENTIFIER="t"><reqif:SPEC-ATTRIBUTES>
   <reqif:ATTRIBUTE-DEFINITION-STRING IDENTIFIER="a-id" LONG-NAME="Object Identifier"/>
   <reqif:ATTRIBUTE-DEFINITION-XHTML IDENTIFIER="a-text" LONG-NAME="reqif.text"/>
   <reqif:ATTRIBUTE-DEFINITION-STRING IDENTIFIER="a-why" LONG-NAME="Begründung"/>
  </reqif:SPEC-ATTRIBUTES></reqif:SPEC-OBJECT-TYPE></reqif:SPEC-TYPES>
  <reqif:SPEC-OBJECTS>
   <reqif:SPEC-OBJECT IDENTIFIER="o1"><reqif:VALUES><reqif:ATTRIBUTE-VALUE-STRING THE-VALUE="SYS-7"><reqif:DEFINITION><reqif:ATTRIBUTE-DEFINITION-STRING-REF>a-id</reqif:ATTRIBUTE-DEFINITION-STRING-REF></reqif:DEFINITION></reqif:ATTRIBUTE-VALUE-STRING></reqif:VALUES></reqif:SPEC-OBJECT>
   <reqif:SPEC-OBJECT IDENTIFIER="o2"><reqif:VALUES>
     <reqif:ATTRIBUTE-VALUE-XHTML><reqif:THE-VALUE><h:div><h:p>The gap is <h:b>20</h:b> cm</h:p><h:p>or more: H<h:sub>2</h:sub>O.</h:p></h:div></reqif:THE-VALUE><reqif:DEFINITION><reqif:ATTRIBUTE-DEFINITION-XHTML-REF>a-text</reqif:ATTRIBUTE-DEFINITION-XHTML-REF></reqif:DEFINITION></reqif:ATTRIBUTE-VALUE-XHTML>
     <reqif:ATTRIBUTE-VALUE-STRING THE-VALUE="near"><reqif:DEFINITION><reqif:ATTRIBUTE-DEFINITION-STRING-REF>a-id</reqif:ATTRIBUTE-DEFINITION-STRING-REF></reqif:DEFINITION></reqif:ATTRIBUTE-VALUE-STRING>
     <reqif:ATTRIBUTE-VALUE-STRING THE-VALUE="room for a &quot;hand&quot;"><reqif:DEFINITION><reqif:ATTRIBUTE-DEFINITION-STRING-REF>a-why</reqif:ATTRIBUTE-DEFINITION-STRING-REF></reqif:DEFINITION></reqif:ATTRIBUTE-VALUE-STRING></reqif:VALUES></reqif:SPEC-OBJECT>
   <reqif:SPEC-OBJECT IDENTIFIER="o3" LONG-NAME="SYS 9.1"><reqif:VALUES>
     <reqif:ATTRIBUTE-VALUE-XHTML><reqif:THE-VALUE><h:div>Not judged
   here</h:div></reqif:THE-VALUE><reqif:DEFINITION><reqif:ATTRIBUTE-DEFINITION-XHTML-REF>a-text</reqif:ATTRIBUTE-DEFINITION-XHTML-REF></reqif:DEFINITION></reqif:ATTRIBUTE-VALUE-XHTML></reqif:VALUES></reqif:SPEC-OBJECT>
  </reqif:SPEC-OBJECTS>
  <reqif:SPECIFICATIONS><reqif:SPECIFICATION IDENTIFIER="s"><reqif:CHILDREN><reqif:SPEC-HIERARCHY IDENTIFIER="h1">
    <reqif:CHILDREN><reqif:SPEC-HIERARCHY IDENTIFIER="h2"><reqif:OBJECT><reqif:SPEC-OBJECT-REF>o2</reqif:SPEC-OBJECT-REF></reqif:OBJECT></reqif:SPEC-HIERARCHY></reqif:CHILDREN>
    <reqif:OBJECT><reqif:SPEC-OBJECT-REF>o1</reqif:SPEC-OBJECT-REF></reqif:OBJECT></reqif:SPEC-HIERARCHY></reqif:CHILDREN></reqif:SPECIFICATION></reqif:SPECIFICATIONS>
 </reqif:REQ-IF-CONTENT></reqif:CORE-CONTENT></reqif:REQ-IF>
"""


class RequirementsTest(ProcessTest):
    def setUp(self):
        super().setUp()
        self.scenario = self.folder / "pass.yaml"
        self.scenario.write_text(SCENARIO)

    def export(self, name, *options):
        out = self.folder / name
        self.run_ok(UNLATCH, "requirements", "export", self.scenario, "--out", out, *options)
        return out

    def import_file(self, name, text, *options, code=0):
        source, part = self.folder / name, self.folder / "part.yaml"
        if text is not None:
            source.write_text(text)
        result = self.run_ok(UNLATCH, "requirements", "import", source, self.scenario, "--out", part, *options, code=code)
        return part, result.stderr

    def read_csv(self, path):
        with path.open(encoding="utf-8", newline="") as stream:
            return list(csv.DictReader(stream))

    def read_back(self):
        """The requirements of the scenario with the part."""
        including = self.folder / "including.yaml"
        including.write_text(SCENARIO.replace("name: pass", "include: part.yaml\nname: pass"))
        out = self.folder / "including.csv"
        self.run_ok(UNLATCH, "requirements", "export", including, "--out", out)
        return {row["id"]: row for row in self.read_csv(out)}

    def check_element(self, node, kinds):
        """By the rules above; notes the identifiers."""
        name = node.tag.removeprefix(NS)
        self.assertTrue(node.tag.startswith(NS), node.tag)
        if name in REFERENCES or not (name in RULES or name in HOLDERS):
            self.assertEqual(len(node), 0, name)
            return
        if name in HOLDERS:
            self.assertEqual([child.tag.removeprefix(NS) in REFERENCES for child in node], [True], name)
            return
        (needed, allowed), elements = RULES[name]
        self.assertLessEqual(needed, set(node.attrib), name)
        self.assertLessEqual(set(node.attrib), needed | allowed, name)
        names = [child.tag.removeprefix(NS) for child in node]
        self.assertLessEqual(set(names), set(elements), name)
        for element, (least, most) in elements.items():
            self.assertTrue(least <= names.count(element) <= most, f"{names.count(element)} of {element} in {name}")
        if "IDENTIFIER" in node.attrib:
            identifier = node.attrib["IDENTIFIER"]
            self.assertRegex(identifier, r"^[A-Za-z_][A-Za-z0-9_.-]*$", "xsd:ID")
            self.assertNotIn(identifier, kinds)
            kinds[identifier] = name
        for key in ("LAST-CHANGE",):
            if key in node.attrib:
                self.assertRegex(node.attrib[key], r"^\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d(\.\d+)?(Z|[+-]\d\d:\d\d)?$")
        for child in node:
            if child.tag.removeprefix(NS) != "THE-VALUE":
                self.check_element(child, kinds)
                continue
            self.assertEqual([inner.tag for inner in child], [XHTML + "div"])

    def read_reqif(self, path):
        root = ElementTree.parse(path).getroot()
        kinds = {}
        self.check_element(root, kinds)
        for node in root.iter():
            if node.tag.removeprefix(NS) in REFERENCES:
                self.assertEqual(kinds.get(node.text), REFERENCES[node.tag.removeprefix(NS)], node.text)
        self.assertEqual(root.find(f".//{NS}REQ-IF-VERSION").text, "1.0")
        names = {node.attrib["IDENTIFIER"]: node.attrib["LONG-NAME"] for node in root.iter() if node.tag.startswith(NS + "ATTRIBUTE-DEFINITION") and "IDENTIFIER" in node.attrib}
        objects = {}
        for node in root.iter(NS + "SPEC-OBJECT"):
            values = {}
            for value in node.find(NS + "VALUES"):
                formatted = value.find(NS + "THE-VALUE")
                values[names[value.find(NS + "DEFINITION")[0].text]] = value.attrib["THE-VALUE"] if formatted is None else "".join(formatted.itertext())
            objects[node.attrib["IDENTIFIER"]] = values
        return root, objects

    def test_reqif_keeps_the_rules_of_its_schema_and_has_every_field(self):
        root, objects = self.read_reqif(self.export("pass.reqif", "--time", "2026-03-01T12:00:00Z"))
        self.assertEqual(root.find(f".//{NS}CREATION-TIME").text, "2026-03-01T12:00:00Z")
        near, nearer, plain = objects.values()
        self.assertEqual(near, {"ReqIF.ForeignID": "near", "ReqIF.Text": TEXT, "Rationale": "a hand's width", "Parent": "SYS-4", "Criterion": near["Criterion"]})
        self.assertEqual(near["Criterion"], "clearance still – moving: at least 0.2 m")
        self.assertEqual(nearer["Parent"], "near")
        self.assertEqual(plain, {"ReqIF.ForeignID": "plain", "Criterion": "time of late: between 0.1 and 1 s"})

    def test_the_hierarchy_of_reqif_follows_the_parents(self):
        root, objects = self.read_reqif(self.export("pass.reqif"))
        ids = {key: values["ReqIF.ForeignID"] for key, values in objects.items()}
        tree = lambda node: {ids[place.find(f"{NS}OBJECT/{NS}SPEC-OBJECT-REF").text]: tree(place) for place in node.findall(f"{NS}CHILDREN/{NS}SPEC-HIERARCHY")}
        self.assertEqual(tree(root.find(f".//{NS}SPECIFICATION")), {"near": {"nearer": {}}, "plain": {}})

    def test_the_identifiers_of_reqif_stay_when_requirements_are_inserted(self):
        def read(name):
            root, objects = self.read_reqif(self.export(name))
            places = {place.attrib["IDENTIFIER"]: place.find(f"{NS}OBJECT/{NS}SPEC-OBJECT-REF").text for place in root.iter(NS + "SPEC-HIERARCHY")}
            return {values["ReqIF.ForeignID"]: (key, next(place for place, to in places.items() if to == key)) for key, values in objects.items()}
        before = read("before.reqif")
        self.scenario.write_text(SCENARIO.replace("requirements:\n", "requirements:\n  - {id: first, time: {event: late}, range: [0, 1]}\n"))
        after = read("after.reqif")
        self.assertEqual({key: after[key] for key in before}, before)
        self.assertEqual(len(set(after.values())), 4)

    def test_parents_in_a_circle_are_written_all_the_same(self):
        self.scenario.write_text(SCENARIO.replace("parent: SYS-4", "parent: nearer"))
        root, objects = self.read_reqif(self.export("pass.reqif"))
        self.assertEqual(len(list(root.iter(NS + "SPEC-HIERARCHY"))), len(objects))

    def test_the_same_scenario_gives_the_same_bytes(self):
        for name in ("a.reqif", "a.csv"):
            self.assertEqual(self.export(name).read_bytes(), self.export("again" + name[1:]).read_bytes())

    def test_what_was_exported_comes_back(self):
        for name in ("back.reqif", "back.csv"):
            self.export(name)
            self.scenario.write_text(re.sub(r"text: .*?, clearance", "clearance", SCENARIO))
            _, printed = self.import_file(name, None)
            got = self.read_back()
            self.scenario.write_text(SCENARIO)
            self.assertEqual([got["near"][key] for key in ("text", "parent", "rationale")], [TEXT, "SYS-4", "a hand's width"], name)
            self.assertEqual(got["nearer"]["parent"], "near")

    def test_csv_is_read_by_other_programs(self):
        rows = self.read_csv(self.export("pass.csv"))
        self.assertEqual([row["id"] for row in rows], ["near", "nearer", "plain"])
        self.assertEqual([rows[0][key] for key in ("parent", "text", "rationale")], ["SYS-4", TEXT, "a hand's width"])

    def test_files_of_other_tools_are_read_by_their_attributes(self):
        part, printed = self.import_file("doors.reqif", FOREIGN, "--rationale", "Begründung")
        self.assertIn("1 requirement of pass set", printed)
        self.assertIn("does not judge 1 requirement: SYS 9.1", printed)
        self.assertIn("has no nearer, plain", printed)
        near = self.read_back()["near"]
        self.assertEqual([near[key] for key in ("text", "parent", "rationale")], ["The gap is 20 cm or more: H2O.", "SYS-7", 'room for a "hand"'])
        self.assertEqual(set(yaml.safe_load(part.read_text())), {"unlatch_part", "set"})
        self.assertIn('#     text: "Not judged here"', part.read_text())

    def test_csv_with_semicolons_quotes_and_a_byte_order_mark(self):
        self.import_file("excel.csv", '\ufeffKennung;Text;Parent\r\nnear;"Zwei\nZeilen; ""so""";SYS-1\r\n', "--id", "kennung")
        self.assertEqual([self.read_back()["near"][key] for key in ("text", "parent")], ['Zwei Zeilen; "so"', "SYS-1"])

    def test_hostile_and_wrong_files_are_refused_with_a_reason(self):
        bomb = '<?xml version="1.0"?><!DOCTYPE b [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;">]><REQ-IF>&b;</REQ-IF>'
        for name, text, reason in (("bomb.reqif", bomb, "document type"), ("half.reqif", FOREIGN[:900], "line "), ("deep.reqif", "<REQ-IF>" + "<a>" * 400, "256"),
                                   ("other.xml", "<html/>", "root is not REQ-IF"), ("zip.reqif", "PK\x03\x04", "unzip"), ("open.csv", 'id,text\nnear,"x', "not closed"),
                                   ("none.csv", "a,b\n1,2\n", "--id"), ("columns.csv", "id,text,Text\nnear,a,b\n", "line 1 has a second column 'Text'"),
                                   ("rows.csv", "id,text\nnear,a\nnear,b\n", "requirement 'near' stands there more than once"),
                                   ("others.csv", "id,text\nfar,a\nfar,b\n", "requirement 'far' stands there more than once"),
                                   ("dangling.reqif", FOREIGN.replace('IDENTIFIER="a-text"', 'IDENTIFIER="a-other"'), "'a-text', which the file does not define")):
            _, printed = self.import_file(name, text, code=2)
            self.assertIn(reason, printed, name)
            self.assertFalse((self.folder / "part.yaml").exists(), name)

    def test_a_file_that_does_not_exist_is_named_by_what_it_should_be(self):
        _, printed = self.import_file("none.reqif", None, code=2)
        self.assertIn("name a readable file of requirements (.reqif, .csv)", printed)

    def test_a_command_line_that_says_too_little_is_refused(self):
        for arguments, reason in ((["export", self.scenario, "--out", "x.doc"], "format"), (["import", "a.csv", "--out", "x.yaml"], "a file and a scenario"),
                                  (["drop", self.scenario, "--out", "x.csv"], "what to do"), (["export", self.scenario, "--out", "x.reqif", "--time", "noon"], "no time")):
            result = call(UNLATCH, "requirements", *arguments)
            self.assertEqual(result.returncode, 2)
            self.assertIn(reason, result.stderr)


if __name__ == "__main__":
    main()
