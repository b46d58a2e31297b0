"""Decodes CCSDS space packets by an XTCE file alone, as a control room does: nothing here knows unlatch. Containers with one base and one
comparison, integers, floats, enumerations and fixed strings of any number of bits, big-endian."""
import struct
import xml.etree.ElementTree as ElementTree

SPACE = "{http://www.omg.org/spec/XTCE/20180204}"


class Bits:
    def __init__(self, data):
        self.data, self.at = data, 0

    def take(self, count):
        if self.at + count > 8 * len(self.data):
            raise ValueError(f"{count} bits from {self.at} on of {8 * len(self.data)}")
        first, last = self.at // 8, (self.at + count + 7) // 8
        number = int.from_bytes(self.data[first:last], "big") >> (8 * last - self.at - count)
        self.at += count
        return number & ((1 << count) - 1)


class Xtce:
    def __init__(self, text):
        root = ElementTree.fromstring(text)
        assert root.tag == SPACE + "SpaceSystem", root.tag
        telemetry = root.find(SPACE + "TelemetryMetaData")
        self.name = root.get("name")
        self.types = {one.get("name"): one for one in telemetry.find(SPACE + "ParameterTypeSet")}
        self.parameters = {one.get("name"): one.get("parameterTypeRef") for one in telemetry.find(SPACE + "ParameterSet")}
        self.aliases = {one.get("name"): one.find(f"{SPACE}AliasSet/{SPACE}Alias").get("alias") for one in telemetry.find(SPACE + "ParameterSet")}
        self.containers = {one.get("name"): one for one in telemetry.find(SPACE + "ContainerSet")}
        missing = set(self.parameters.values()) - set(self.types)
        assert not missing, missing

    def get_unit(self, parameter):
        unit = self.types[self.parameters[parameter]].find(f"{SPACE}UnitSet/{SPACE}Unit")
        return "" if unit is None else unit.text

    def read(self, bits, parameter):
        kind = self.types[self.parameters[parameter]]
        integer, real, text = (kind.find(f"{SPACE}{name}DataEncoding") for name in ("Integer", "Float", "String"))
        if real is not None:
            size = int(real.get("sizeInBits"))
            return struct.unpack({32: ">f", 64: ">d"}[size], bits.take(size).to_bytes(size // 8, "big"))[0]
        if text is not None:
            size = int(text.find(f"{SPACE}SizeInBits/{SPACE}Fixed/{SPACE}FixedValue").text)
            end = bytes.fromhex(text.find(f"{SPACE}SizeInBits/{SPACE}TerminationChar").text)
            return bits.take(size).to_bytes(size // 8, "big").split(end)[0].decode()
        size = int(integer.get("sizeInBits"))
        number = bits.take(size)
        if integer.get("encoding") == "twosComplement" and number >> (size - 1):
            number -= 1 << size
        labels = {int(one.get("value")): one.get("label") for one in kind.iter(SPACE + "Enumeration")}
        return labels[number] if labels else number

    def decode(self, packet):
        """Container and values by alias; every bit of the packet has a meaning."""
        bits = Bits(packet)
        base = next(name for name, one in self.containers.items() if one.get("abstract") == "true")
        values = self.read_entries(bits, base)
        for name, one in self.containers.items():
            link = one.find(SPACE + "BaseContainer")
            if link is None or link.get("containerRef") != base:
                continue
            comparison = link.find(f"{SPACE}RestrictionCriteria/{SPACE}Comparison")
            if values[self.aliases[comparison.get("parameterRef")]] == int(comparison.get("value")):
                values.update(self.read_entries(bits, name))
                assert bits.at == 8 * len(packet), (name, bits.at, 8 * len(packet))
                return name, values
        raise ValueError(f"no container for {packet[:8].hex()}")

    def read_entries(self, bits, container):
        entries = self.containers[container].find(SPACE + "EntryList")
        return {self.aliases[entry.get("parameterRef")]: self.read(bits, entry.get("parameterRef")) for entry in entries}


def split(stream):
    """Whole packets of a byte stream, by the length in their primary header."""
    packets, at = [], 0
    while at + 6 <= len(stream):
        end = at + 7 + int.from_bytes(stream[at + 4:at + 6], "big")
        if end > len(stream):
            break
        packets.append(stream[at:end])
        at = end
    return packets
