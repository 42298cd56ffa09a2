"""Logs of every kind with known content, written byte by byte after the formats' published descriptions."""

import struct
from collections.abc import Callable
from typing import NamedTuple
from zlib import crc32

import numpy as np

G = 9.80665
FRD = np.array([1.0, -1.0, -1.0])
MAPPING = """
axes = "FRD"
time = { column = "t", unit = "ms" }
gyro = { columns = ["p", "q", "r"], unit = "deg/s" }
acceleration = { columns = ["ax", "ay", "az"], unit = "g" }
command = { columns = ["fl", "fr", "rl", "rr"], idle = 1000, full = 2000 }
setpoint = { columns = ["sp", "sq", "sr"], unit = "deg/s" }
"""


class Truth(NamedTuple):
    time: np.ndarray
    gyro: np.ndarray
    acceleration: np.ndarray
    command: np.ndarray


def truth(count=600, rate=500.0):
    """Rates [rad/s] and specific force [m/s2] in FLU, commands front left, front right, rear left, rear right."""
    t = 2.0 + np.arange(count) / rate
    gyro = np.column_stack([np.sin(3.0 * t), 0.5 * np.cos(5.0 * t), 0.2 * np.sin(t)])
    acceleration = np.column_stack([0.3 * np.sin(t), 0.1 * np.cos(t), G + np.sin(2.0 * t)])
    command = 0.5 + 0.1 * np.column_stack([np.sin((k + 1.0) * t + k) for k in range(4)])
    return Truth(t, gyro, acceleration, command)


def crazyflie(log, version=2):
    names = [f"{kind}.{axis}(f)" for kind in ("acc", "gyro") for axis in "xyz"] + [
        f"motor.m{i}(I)" for i in range(1, 5)
    ]
    head = struct.pack("<BHHH", 0xBC, version, 1, 65535) + b"fixedFrequency\0" + struct.pack("<H", len(names))
    head += b"".join(name.encode() + b"\0" for name in names)
    # Motors m1 to m4: front right, rear right, rear left, front left.
    motors = np.round(65535.0 * log.command[:, [1, 3, 2, 0]]).astype(int)
    stamp, unit = ("<HI", 1e3) if version == 1 else ("<HQ", 1e6)
    rows = [
        struct.pack(stamp, 65535, round(unit * t)) + struct.pack("<6f4I", *(a / G), *np.degrees(w), *m)
        for t, w, a, m in zip(log.time, log.gyro, log.acceleration, motors, strict=True)
    ]
    body = head + b"".join(rows)
    return body + struct.pack("<I", crc32(body))


def csv(log):
    table = np.column_stack(
        [
            1e3 * log.time,
            np.degrees(log.gyro * FRD),
            log.acceleration * FRD / G,
            1000.0 + 1000.0 * log.command,
            np.degrees(0.5 * log.gyro * FRD),
            log.time,
        ]
    )
    lines = [
        "t,p,q,r,ax,ay,az,fl,fr,rl,rr,sp,sq,sr,other",
        *[",".join(f"{value:.9g}" for value in row) for row in table],
    ]
    return "\n".join(lines).encode() + b"\n"


def betaflight(log):
    head = ["loopIteration", "time (us)", *[f"gyroADC[{i}]" for i in range(3)], *[f"accSmooth[{i}]" for i in range(3)]]
    head += [f"motor[{i}]" for i in range(4)]
    # Motors 1 to 4: rear right, front right, rear left, front left.
    motors = 48.0 + (2047.0 - 48.0) * log.command[:, [3, 1, 2, 0]]
    table = np.column_stack(
        [np.arange(len(log.time)), 1e6 * log.time, np.degrees(log.gyro), log.acceleration * 2048.0 / G, motors]
    )
    return "\n".join([", ".join(head), *[", ".join(f"{v:.10g}" for v in row) for row in table]]).encode() + b"\n"


def blackbox(log, setpoint=None):
    """A recording of Betaflight in high resolution: every 32nd frame stands alone, others are differences.

    setpoint: of the rates [rad/s]; half of the rates where none are given.
    """
    names = [
        "loopIteration",
        "time",
        *[f"{kind}[{i}]" for kind in ("setpoint", "gyroADC", "accSmooth") for i in range(3)],
    ]
    names += [f"motor[{i}]" for i in range(4)]
    heads = {
        "Product": "Blackbox flight data recorder by Nicholas Sherlock",
        "Data version": "2",
        "I interval": "32",
        "P interval": "1/1",
        "Field I name": ",".join(names),
        "Field I signed": ",".join("1" for _ in names),
        "Field I predictor": ",".join("0" for _ in names),
        "Field I encoding": ",".join("0" for _ in names),
        "Field P predictor": ",".join(["6", *["1"] * (len(names) - 1)]),
        "Field P encoding": ",".join(["9", *["0"] * (len(names) - 1)]),
        "Firmware revision": "Betaflight 4.5.1 (77d01ba3b) STM32F7X2",
        "acc_1G": "2048",
        "motorOutput": "158,2047",
        "blackbox_high_resolution": "1",
    }
    rates, setpoints = (
        10.0 * np.degrees(part) for part in (log.gyro, 0.5 * log.gyro if setpoint is None else setpoint)
    )
    motors = 48.0 + (2047.0 - 48.0) * log.command[:, [3, 1, 2, 0]]
    table = np.column_stack(
        [np.arange(len(log.time)), 1e6 * log.time, setpoints, rates, log.acceleration * 2048.0 / G, motors]
    )
    rows = np.round(table).astype(int).tolist()
    found = "".join(f"H {name}:{value}\n" for name, value in heads.items()).encode()
    for k, row in enumerate(rows):
        alone = k % 32 == 0
        values = row if alone else [now - before for now, before in zip(row[1:], rows[k - 1][1:], strict=True)]
        found += (b"I" if alone else b"P") + b"".join(map(signed_varint, values))
    return found + b"E\xffEnd of log\0"


def signed_varint(value):
    """A whole number in zigzag, seven bits a byte, the lowest first."""
    rest, found = (value << 1) ^ (value >> 63), b""
    while rest > 127:
        rest, found = rest >> 7, found + bytes([rest & 127 | 128])
    return found + bytes([rest])


def ulog(log):
    def message(kind, content):
        return struct.pack("<HB", len(content), ord(kind)) + content

    formats = (
        b"sensor_combined:uint64_t timestamp;float[3] gyro_rad;float[3] accelerometer_m_s2;",
        b"actuator_motors:uint64_t timestamp;float[4] control;",
        b"vehicle_rates_setpoint:uint64_t timestamp;float roll;float pitch;float yaw;",
    )
    found = b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 0) + message("B", bytes(40))
    found += b"".join(message("F", text) for text in formats)
    found += b"".join(message("A", struct.pack("<BH", 0, i) + text.split(b":")[0]) for i, text in enumerate(formats))
    # Motors 1 to 4: front right, rear left, front left, rear right.
    for t, w, a, u in zip(log.time, log.gyro * FRD, log.acceleration * FRD, log.command[:, [1, 2, 0, 3]], strict=True):
        stamp = round(1e6 * t)
        found += message("D", struct.pack("<HQ4f", 1, stamp, *u)) + message("D", struct.pack("<HQ6f", 0, stamp, *w, *a))
        found += message("D", struct.pack("<HQ3f", 2, stamp, *(0.5 * w)))
    return found


def dataflash(log):
    def described(number, length, name, letters, columns):
        texts = struct.pack("<4s16s64s", name.encode(), letters.encode(), columns.encode())
        return b"\xa3\x95\x80" + struct.pack("<BB", number, length) + texts

    found = described(128, 89, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns")
    found += described(129, 3 + 8 + 1 + 24, "IMU", "QBffffff", "TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ")
    found += described(130, 3 + 8 + 8, "RCOU", "QHHHH", "TimeUS,C1,C2,C3,C4")
    found += described(131, 3 + 8 + 12, "RATE", "Qfff", "TimeUS,RDes,PDes,YDes")
    pulses = np.round(1000.0 + 1000.0 * log.command[:, [1, 2, 0, 3]]).astype(int)
    for t, w, a, u in zip(log.time, log.gyro * FRD, log.acceleration * FRD, pulses, strict=True):
        stamp = round(1e6 * t)
        found += (
            b"\xa3\x95\x82" + struct.pack("<Q4H", stamp, *u) + b"\xa3\x95\x81" + struct.pack("<QB6f", stamp, 0, *w, *a)
        )
        found += b"\xa3\x95\x83" + struct.pack("<Q3f", stamp, *np.degrees(0.5 * w))
    return found


WRITERS: dict[str, Callable[..., bytes]] = {
    "Crazyflie SD card": crazyflie,
    "CSV": csv,
    "Betaflight blackbox (.bbl)": blackbox,
    "Betaflight blackbox as CSV": betaflight,
    "PX4 ULog": ulog,
    "ArduPilot DataFlash (.bin)": dataflash,
}
"""Kind of log -> what writes one."""
