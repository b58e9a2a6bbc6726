"""Frames and message bodies in Python: what firmware/link/frame.c and fields.c do in C. The messages: link_messages.py.

Standard library only.
"""
import math
import struct

FRAME_MIN, FRAME_MAX = 9, 400
NUMBERS = {"u8": "<B", "u16": "<H", "u32": "<I", "u64": "<Q", "f32": "<f", "real": "<d"}
CHARACTERS = frozenset(range(32, 127)) | {10, 13}


def _crc_table():
    table = []
    for byte in range(256):
        for _ in range(8):
            byte = byte >> 1 ^ (0x82F63B78 if byte & 1 else 0)
        table.append(byte)
    return table


_TABLE = _crc_table()


def crc32c(data, crc=0):
    crc ^= 0xFFFFFFFF
    for byte in data:
        crc = crc >> 8 ^ _TABLE[(crc ^ byte) & 255]
    return crc ^ 0xFFFFFFFF


def cobs(data):
    """Packed without a 00."""
    packed, code_at = bytearray(1), 0
    for byte in data:
        if len(packed) - code_at == 255:     # full; closed only now, for a full last group needs no other behind it
            packed[code_at] = 255
            code_at = len(packed)
            packed.append(0)
        if byte:
            packed.append(byte)
        else:
            packed[code_at] = len(packed) - code_at
            code_at = len(packed)
            packed.append(0)
    packed[code_at] = len(packed) - code_at
    return bytes(packed)


def raw_frame(number, seq, body=b""):
    """A frame of any type number and body."""
    payload = struct.pack("<BI", number, seq) + bytes(body)
    return b"\0" + cobs(payload + struct.pack("<I", crc32c(payload))) + b"\0"


def pack(fields, values):
    """Body of a message from {name: value}. ValueError if a field is missing, unknown or has a value it cannot have."""
    strange = set(values) ^ {name for name, *_ in fields}
    if strange:
        raise ValueError("fields missing or unknown: " + ", ".join(sorted(strange)))
    return b"".join(_pack_one(*field, values[field[0]]) for field in fields)


def _pack_one(name, kind, low, high, value):
    if kind == "text":
        data = value.encode("ascii")
        if len(data) > high or not CHARACTERS.issuperset(data):
            raise ValueError(f"{name}: not a text of at most {high} characters: {value!r}")
        return struct.pack("<H", len(data)) + data
    if kind in ("f32", "real"):
        if not math.isfinite(value):
            raise ValueError(f"{name}: not finite: {value!r}")
    elif not low <= value <= high:
        raise ValueError(f"{name}: {value!r} is not within {low} .. {high}")
    return struct.pack(NUMBERS[kind], value)


def unpack(fields, body):
    """-> {name: value}, None if the body is not one of these fields."""
    values, at = {}, 0
    for name, kind, low, high in fields:
        form = "<H" if kind == "text" else NUMBERS[kind]
        if len(body) - at < struct.calcsize(form):
            return None
        value, = struct.unpack_from(form, body, at)
        at += struct.calcsize(form)
        if kind == "text":
            data = body[at:at + value]
            if value > high or len(data) != value or not CHARACTERS.issuperset(data):
                return None
            at += value
            value = data.decode("ascii")
        elif not (math.isfinite(value) if kind in ("f32", "real") else low <= value <= high):
            return None
        values[name] = value
    return values if at == len(body) else None


class FrameReceiver:
    """Bytes in any pieces -> frames, by the steps of frame.c. `good` and `bad` count frames received and dropped."""

    def __init__(self):
        self.good = self.bad = 0
        self._inside = False                 # deaf until the first 00
        self._begin()

    def _begin(self):
        self._payload, self._left, self._code = bytearray(), 0, 0

    def feed_raw(self, data):
        """-> [(type number, seq, body), ...]"""
        frames = []
        for byte in data:
            if byte == 0:
                frames += self._finish()
                self._inside = True
                self._begin()
            elif self._inside:
                self._take(byte)
        return frames

    def _take(self, byte):
        if self._left:
            self._left -= 1
            self._payload.append(byte)
        else:
            if self._code not in (0, 255):
                self._payload.append(0)
            self._code, self._left = byte, byte - 1
        if len(self._payload) > FRAME_MAX:
            self._inside = False
            self.bad += 1

    def _finish(self):
        payload = bytes(self._payload)
        if not self._inside or not self._code:
            return []
        if self._left or len(payload) < FRAME_MIN or payload[-4:] != struct.pack("<I", crc32c(payload[:-4])):
            self.bad += 1
            return []
        self.good += 1
        return [(payload[0], struct.unpack_from("<I", payload, 1)[0], payload[5:-4])]


def job(case_crc, seed):
    """Names a case and a seed, as in the message result."""
    return crc32c(struct.pack("<IQ", case_crc, seed))


def draw_crc(draw):
    """Of fc, mu, a1, a2, w0, as in the message result."""
    return crc32c(struct.pack("<5d", *draw))
