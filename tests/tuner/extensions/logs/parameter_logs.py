"""Logs with parameters and nothing else, written byte by byte after the formats' published descriptions."""

import struct


def ulog(values, release=0x010E03FF, name=b"PX4"):
    """A ULog with initial parameters, whole numbers as int32; release: packed version of the firmware."""

    def message(kind, content):
        return struct.pack("<HB", len(content), ord(kind)) + content

    def keyed(kind, key, content):
        return message(kind, bytes([len(key)]) + key + content)

    log = b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 0) + message("B", bytes(40))
    log += keyed("I", b"char[%d] sys_name" % len(name), name) + keyed(
        "I", b"uint32_t ver_sw_release", struct.pack("<I", release)
    )
    for key, value in values.items():
        is_whole = isinstance(value, int)
        kind = b"int32_t " if is_whole else b"float "
        log += keyed("P", kind + key.encode(), struct.pack("<i" if is_whole else "<f", value))
    log += message("F", b"sensor_combined:uint64_t timestamp;") + message(
        "A", struct.pack("<BH", 0, 0) + b"sensor_combined"
    )
    return log + message("D", struct.pack("<HQ", 0, 1))


def dataflash(values, banner="ArduCopter V4.5.7 (2a3dc4b7)"):
    """A DataFlash log; values: pairs of name and value in the order of their messages."""

    def described(number, length, name, letters, columns):
        texts = struct.pack("<4s16s64s", name.encode(), letters.encode(), columns.encode())
        return b"\xa3\x95\x80" + struct.pack("<BB", number, length) + texts

    log = described(128, 89, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns")
    log += described(32, 3 + 8 + 16 + 8, "PARM", "QNff", "TimeUS,Name,Value,Default")
    log += described(33, 3 + 8 + 64, "MSG", "QZ", "TimeUS,Message")
    log += b"\xa3\x95\x21" + struct.pack("<Q64s", 1, banner.encode())
    return log + b"".join(
        b"\xa3\x95\x20" + struct.pack("<Q16sff", 2, name.encode(), value, 0.0) for name, value in values
    )
