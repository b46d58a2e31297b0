"""Rules of FMI 2.0.4 and 3.0.1 for modelDescription.xml, written from the standards' text and schemas; for co-simulation and
real variables, which is what our FMUs have."""
import math
import re

IDENTIFIER = r"(?:[A-Za-z_]\w*|'(?:[^'\\]|\\.)+')(?:\[\d+(?:,\d+)*\])?"
STRUCTURED = re.compile(rf"(?:{IDENTIFIER}(?:\.{IDENTIFIER})*|der\({IDENTIFIER}(?:\.{IDENTIFIER})*(?:,\d+)?\))\Z", re.ASCII)
ORDER = ["ModelExchange", "CoSimulation", "ScheduledExecution", "UnitDefinitions", "TypeDefinitions", "LogCategories",
         "DefaultExperiment", "VendorAnnotations", "ModelVariables", "ModelStructure", "Annotations"]
BASE = {"kg", "m", "s", "A", "K", "mol", "cd", "rad", "factor", "offset"}
COMMON = {"name", "valueReference", "description", "causality", "variability"}
REAL = {"unit", "min", "max", "start"}
ROOT = {"fmiVersion", "modelName", "generationTool", "variableNamingConvention", "description", "version"}
FMU = {"modelIdentifier", "canHandleVariableCommunicationStepSize"}
STATES = {3: {"canGetAndSetFMUState", "canSerializeFMUState", "hasEventMode", "canReturnEarlyAfterIntermediateUpdate", "fixedInternalStepSize"},
          2: {"canGetAndSetFMUstate", "canSerializeFMUstate"}}


def list_faults(root, version):
    """Returns a sentence for each broken rule of the description's root element."""
    faults = []

    def rule(holds, text):
        if not holds:
            faults.append(text)

    token = "instantiationToken" if version == 3 else "guid"
    rule(root.tag == "fmiModelDescription" and root.get("fmiVersion") == f"{version}.0", "root element and version")
    rule(root.get("modelName") and root.get(token), f"modelName and {token} are required")
    rule(set(root.keys()) <= ROOT | {token}, f"unknown attributes of the root: {sorted(set(root.keys()) - ROOT - {token})}")
    places = [ORDER.index(child.tag) if child.tag in ORDER else -1 for child in root]
    rule(places == sorted(places) and -1 not in places, f"order of elements: {[child.tag for child in root]}")
    simulation = root.find("CoSimulation")
    rule(re.fullmatch(r"[A-Za-z_]\w*", simulation.get("modelIdentifier"), re.ASCII), "modelIdentifier is no C identifier")
    rule(set(simulation.keys()) <= FMU | STATES[version], f"unknown attributes of CoSimulation: {sorted(simulation.keys())}")
    units = [unit.get("name") for unit in root.find("UnitDefinitions")]
    rule(len(set(units)) == len(units), "a unit is defined twice")
    for unit in root.find("UnitDefinitions"):
        for base in unit:
            rule(base.tag == "BaseUnit" and set(base.keys()) <= BASE, f"BaseUnit of {unit.get('name')}")
    experiment = {key: float(value) for key, value in root.find("DefaultExperiment").items()}
    rule(experiment["startTime"] < experiment["stopTime"] and 0 < experiment["stepSize"] <= experiment["stopTime"], "DefaultExperiment")

    variables = list(root.find("ModelVariables"))
    names = [variable.get("name") for variable in variables]
    rule(len(set(names)) == len(names), "a name occurs twice")
    rule(all(re.fullmatch(r"\d+", variable.get("valueReference")) for variable in variables), "a value reference is no unsigned number")
    rule(len({variable.get("valueReference") for variable in variables}) == len(variables), "two variables share a value reference")
    rule([v.get("causality") for v in variables].count("independent") == 1, "one independent variable")
    convention = root.get("variableNamingConvention", "flat")
    rule(convention in ("flat", "structured"), f"naming convention {convention}")
    for variable in variables:
        name, causality, variability = variable.get("name"), variable.get("causality"), variable.get("variability")
        real = variable if version == 3 else variable[0]
        rule(name and not re.search(r"[\r\n\t]", name), f"{name!r} is no name")
        rule(convention == "flat" or STRUCTURED.match(name), f"{name!r} is no structured name")
        rule(real.tag == ("Float64" if version == 3 else "Real"), f"{name}: type {real.tag}")
        rule(set(variable.keys()) | set(real.keys()) <= COMMON | REAL, f"{name}: unknown attributes")
        rule(real.get("unit") is None or real.get("unit") in units, f"{name}: unit {real.get('unit')} is not defined")
        # Table 20 of 2.0.4, table 18 of 3.0.1: which pairs of causality and variability exist, and which of them have a start.
        rule((causality, variability) in {("independent", "continuous"), ("input", "continuous"), ("output", "continuous"), ("parameter", "fixed")},
             f"{name}: {causality} and {variability}")
        rule((real.get("start") is not None) == (causality in ("input", "parameter")), f"{name}: start of an {causality}")
        numbers = {key: float(real.get(key)) for key in ("min", "start", "max") if real.get(key) is not None}
        rule(all(map(math.isfinite, numbers.values())), f"{name}: {numbers}")
        rule(list(numbers.values()) == sorted(numbers.values()), f"{name}: start outside of its range")

    structure = root.find("ModelStructure")
    for kind in ("Output", "InitialUnknown"):
        listed = [int(unknown.get("valueReference" if version == 3 else "index"))
                  for unknown in (structure.findall(kind) if version == 3 else structure.find(f"{kind}s"))]
        outputs = [int(v.get("valueReference")) if version == 3 else place + 1 for place, v in enumerate(variables)
                   if v.get("causality") == "output"]
        rule(sorted(listed) == outputs, f"{kind}s are not the outputs")
    return faults
