#!/usr/bin/env python3
"""Claims about the link: the generated files, the C codec against the Python codec, damaged streams, WITS read back. Fuzzed by tests/check_fuzz.py.

Prints one line for each claim that fails, then `N passed, N failed`; exit 1 if any failed.
"""
import math
import os
import random
import re
import struct
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True
ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
sys.path[:0] = [os.path.join(ROOT, "host"), os.path.join(ROOT, "gen")]

import faulty_line                          # noqa: E402
import link_codec                           # noqa: E402
import link_messages as link                # noqa: E402
import protocol                             # noqa: E402
import wits                                 # noqa: E402

MADE = ("firmware/link/messages.h", "firmware/link/messages.c", "firmware/link/PROTOCOL.md", "host/link_messages.py")
CODEC = [os.path.join(ROOT, "firmware", "link", name + ".c") for name in ("frame", "crc32c", "fields", "messages", "wits")]
CFLAGS = "-std=c11 -pedantic -Wall -Wextra -Wconversion -Wshadow -Wundef -Wcast-qual -Werror -O1 -g -ffp-contract=off".split()
OUT = os.path.join(ROOT, "build", "link")
count = {True: 0, False: 0}


def claim(holds, text):
    holds = bool(holds)
    count[holds] += 1
    if not holds:
        print("FAILED: " + text, flush=True)
    return holds


def run(*command, **options):
    return subprocess.run(command, capture_output=True, check=False, timeout=120, **options)


def read(path):
    with open(path, "rb") as file:
        return file.read()


# ---- generated files

def bytes_repeat(directory):
    for seed in ("0", "1"):
        ran = run(sys.executable, os.path.join(ROOT, "gen", "protocol.py"), "--out", directory, env={**os.environ, "PYTHONHASHSEED": seed})
        claim(ran.returncode == 0 and not ran.stdout + ran.stderr, f"the generator runs: {ran.stderr.decode()}")
        for path in MADE:
            claim(read(os.path.join(directory, path)) == read(os.path.join(ROOT, path)), f"{path} regenerates to the committed bytes")


def schema_follows_the_layout():
    """Every change of layout changes the number, a change of prose does not; hello stays as it is."""
    def schema(messages):
        old, protocol.MESSAGES = protocol.MESSAGES, messages
        try:
            return link_codec.crc32c(protocol.canonical().encode())
        finally:
            protocol.MESSAGES = old

    messages = protocol.MESSAGES
    claim(schema(messages) == link.SCHEMA, "the schema is the CRC of the canonical text")
    seen = {link.SCHEMA}
    for i, message in enumerate(messages):
        claim(schema(messages[:i] + [message._replace(meaning="other words")] + messages[i + 1:]) == link.SCHEMA, f"prose of {message.name}")
        for k, field in enumerate(message.fields):
            kind = "u32" if field.kind != "u32" else "u64"
            for other in (field._replace(kind=kind), field._replace(name=field.name + "_")):
                fields = message.fields[:k] + (other,) + message.fields[k + 1:]
                seen.add(schema(messages[:i] + [message._replace(fields=fields)] + messages[i + 1:]))
    claim(len(seen) == 1 + 2 * sum(len(m.fields) for m in messages), "each change of a field gives a schema of its own")
    claim([m.number for m in messages] == list(range(1, len(messages) + 1)), "numbers follow each other")
    frozen = [(m.number, m.name, [(f.name, f.kind) for f in m.fields[:2]]) for m in messages[:2]]
    words = [("schema", "u32"), ("nonce", "u32")]
    claim(frozen == [(1, "hello", words), (2, "hello_reply", words)] and len(messages[0].fields) == 2, "hello is frozen")


def page_is_true():
    page = read(os.path.join(ROOT, "firmware", "link", "PROTOCOL.md")).decode()
    example = bytes.fromhex(re.search(r"Example, hello .*?: `(.*?)`", page)[1])
    claim(link.Receiver().feed(example) == [("hello", 7, {"schema": link.SCHEMA, "nonce": 1})], "the page's example is that hello")
    for name, (number, sender, _) in link.MESSAGES.items():
        claim(f"### {number} {name} (from the {sender})" in page, f"the page has {name}")


# ---- Python alone

def python_has_the_known_answers():
    count_up, from_two = bytes(range(1, 256)), bytes(range(2, 256)) + b"\0"
    known = [(b"", "01"), (b"\0", "01 01"), (b"\x11\x22\0\x33", "03 11 22 02 33"), (b"\x11\0\0\0", "02 11 01 01 01"),
             (count_up[:254], "FF " + count_up[:254].hex()), (count_up, "FF " + count_up[:254].hex() + "02 FF"),
             (from_two, "FF " + from_two[:254].hex() + "01 01")]
    for plain, packed in known:
        claim(link_codec.cobs(plain) == bytes.fromhex(packed), f"COBS of {plain[:8].hex()}...")
    claim(link_codec.crc32c(b"123456789") == 0xE3069283, "CRC-32C of 123456789")
    good = {"schema": 1, "nonce": 2}
    for fields in ({}, {"schema": 1}, {**good, "more": 1}, {**good, "nonce": -1}, {**good, "nonce": 2 ** 32}):
        try:
            link.frame("hello", 1, **fields)
            claim(False, f"frame refuses {fields}")
        except ValueError:
            claim(True, "")


# ---- C against Python

def build(name, sources, *flags, cc="gcc"):
    path = os.path.join(OUT, name)
    ran = run(cc, *CFLAGS, *flags, *sources, "-o", path)
    return path if claim(ran.returncode == 0, f"{name} builds with {cc}: {ran.stderr.decode()[:2000]}") else None


def some_value(kind, low, high, rng, is_float):
    if kind == "text":
        return "".join(chr(rng.choice(sorted(link_codec.CHARACTERS))) for _ in range(rng.choice((0, 1, high // 2, high))))
    if kind in ("f32", "real"):
        form = "<f" if kind == "f32" or is_float else "<d"
        while not math.isfinite(value := struct.unpack(form, rng.randbytes(struct.calcsize(form)))[0]):
            pass
        return rng.choice((value, value, 0.0, -0.0, 1.0))
    return rng.choice((low, high, rng.randint(low, high)))


def some_messages(n, rng, is_float):
    """[(name, seq, fields)], every type among them; a mode of 0 or 1 does not exist, nor a mode above 3."""
    names = list(link.MESSAGES)
    return [(name, rng.getrandbits(32), {field: some_value(kind, low, high, rng, is_float)
                                         for field, kind, low, high in link.MESSAGES[name][2]})
            for name in (names[i % len(names)] for i in range(n))]


def echo(tool, data):
    """What the C side makes of these bytes -> (messages, (good, bad))"""
    receiver = link.Receiver()
    messages = receiver.feed(run(tool, "echo", input=data).stdout)
    claim(receiver.bad == 0 and messages and messages[-1][0] == "status", "all that C sends is received")
    counts = messages.pop()[2]
    return messages, (counts["good"], counts["bad"])


def bits(message):
    """Equal only for equal bits: -0 is not 0."""
    name, seq, fields = message
    return name, seq, tuple((key, struct.pack("<d", value) if isinstance(value, float) else value) for key, value in fields.items())


def codecs_agree(tool, is_float):
    rng = random.Random(1)
    sent = some_messages(2000, rng, is_float)
    frames = [link.frame(name, seq, **fields) for name, seq, fields in sent]
    got, counts = echo(tool, b"".join(frames))
    claim(counts == (len(sent), 0), f"C receives every frame that Python makes: {counts}")
    claim([bits(m) for m in got] == [bits(m) for m in sent], "Python to C to Python: the same fields, bit by bit")
    again = run(tool, "echo", input=b"".join(frames)).stdout
    claim(again.startswith(b"".join(frames)), "C makes of each message the bytes that Python makes")


def refusals_agree(tool, is_float):
    """Bodies changed at one place: what Python takes C takes, and no other, but for doubles in a float build."""
    rng = random.Random(2)
    for name, (number, _, layout) in link.MESSAGES.items():
        bodies = []
        for _ in range(60):
            body = bytearray(link_codec.pack(layout, some_messages(1, rng, is_float)[0][2]) if name == "hello" else
                             link_codec.pack(layout, {f: some_value(k, lo, hi, rng, is_float) for f, k, lo, hi in layout}))
            change = rng.choice(("byte", "ones", "shorter", "longer"))
            if change == "longer":
                body += rng.randbytes(1)
            elif body and change == "shorter":
                del body[rng.randrange(len(body)):]
            elif body:
                at = rng.randrange(len(body))
                body[at:at + 4] = b"\xff" * len(body[at:at + 4]) if change == "ones" else rng.randbytes(1) + body[at + 1:at + 4]
            bodies.append(bytes(body))
        got, _ = echo(tool, b"".join(link.raw_frame(number, k, body) for k, body in enumerate(bodies)))
        for body, (answer, _, fields) in zip(bodies, got):
            values = link_codec.unpack(layout, body)
            exact = values is not None and not (is_float and any(
                kind == "real" and not is_a_float(values[field]) for field, kind, _, _ in layout))
            taken = answer == name and (name != "error" or link_codec.pack(layout, fields) == body)
            claim(taken == exact and len(got) == len(bodies), f"{name}: C {'takes' if taken else 'refuses'} {body.hex()}")
    got, _ = echo(tool, b"".join(link.raw_frame(n, n) for n in range(21, 256)) + link.raw_frame(0, 0))
    claim([(m[0], m[2]["code"], m[2]["of_type"]) for m in got] == [("error", 2, n) for n in (*range(21, 256), 0)], "unknown types")


def is_a_float(value):
    return abs(value) < 3.5e38 and struct.unpack("<f", struct.pack("<f", value))[0] == value


def damage_is_noticed(tool, is_float):
    """Damaged streams: C and Python receive the same, and nothing that was not sent."""
    rng = random.Random(3)
    for rate in (1e-4, 1e-3, 1e-2, 5e-2):
        sent = some_messages(1500, rng, is_float)
        faults = faulty_line.Faults(rate, faulty_line.KINDS, f"{rate}")
        stream = faults(b"".join(link.frame(name, seq, **fields) for name, seq, fields in sent) + bytes(2))
        receiver = link.Receiver()
        here = receiver.feed(stream)
        there, counts = echo(tool, stream)
        claim([bits(m) for m in here] == [bits(m) for m in there] and counts == (receiver.good, receiver.bad), f"C and Python agree at {rate}")
        rest = iter(bits(m) for m in sent)
        claim(all(any(bits(m) == one for one in rest) for m in here), f"nothing is received that was not sent, in order, at {rate}")
        claim(0 < receiver.bad and len(here) > 0, f"some frames are lost at {rate} and some are not: {len(here)} of {len(sent)}")
    noise = random.Random(4).randbytes(1 << 20) + b"\0" + link.frame("stop", 5)
    receiver = link.Receiver()
    here = receiver.feed(noise)
    there, counts = echo(tool, noise)
    claim(here == there == [("stop", 5, {})] and counts == (receiver.good, receiver.bad), "1 MB of noise, and the frame behind it")
    largest = link.raw_frame(99, 1, bytes(391))
    stream = largest + link.raw_frame(99, 2, bytes(392)) + largest
    receiver = link.Receiver()
    receiver.feed(stream)
    _, counts = echo(tool, stream)
    claim(counts == (receiver.good, receiver.bad) == (2, 1), "a frame of maximal size, one byte more, and again")


# ---- WITS

REALS = ("0108", "0116", "0117", "0118", "0119", "0120", "0915", "0916", "0917", "0918", "0921", "0922", "0923", "0924", "0926")
UNITS = dict(zip(REALS, (1.0, 1e-4, 1e-4, 1e-3, 1e-3, 30.0 / math.pi, 1e-4, 1e-4, 1e-3, 1e-3, *[30.0 / math.pi] * 3, 1.0, 1.0)))
GROUPS = {"0105": 1, "0106": 1, "0108": 2, **dict.fromkeys(REALS[1:6], 4), **dict.fromkeys(REALS[6:14], 8), "0926": 16, "0927": 16}


def wits_reads_back(tool):
    rng = random.Random(5)
    sent = []
    for _ in range(400):
        size = rng.choice((1.0, 50.0, 5000.0))
        reals = {item: rng.uniform(-0.2, 1.0) * size / UNITS[item] for item in REALS}
        sent.append((rng.randrange(32), rng.choice((0, 2)), rng.randrange(10 ** 6), rng.randrange(240000), reals, rng.getrandbits(32)))
    lines = "".join(" ".join(map(repr, (known, activity, date, clock, *reals.values(), samples))) + "\n"
                    for known, activity, date, clock, reals, samples in sent)
    output = run(tool, "wits", input=lines.encode()).stdout
    try:
        got = wits.frames(b"noise && !!\r\n" + output)
    except wits.WitsError as error:
        return claim(False, f"the strict reader takes what C writes: {error}")
    claim(len(got) == len(sent), f"{len(got)} frames of {len(sent)}")
    claim(output.isascii() and len(output) <= 360 * len(sent), "ASCII, at most 360 characters a frame")
    for (known, activity, date, clock, reals, samples), frame in zip(sent, got):
        want = {**{item: value * UNITS[item] for item, value in reals.items()}, "0105": date if date <= 991231 else None,
                "0106": clock if clock <= 235959 else None, "0107": activity, "0927": samples}
        for item in wits.ITEMS:
            if item in ("0113", "0925"):
                continue
            value = want[item] if item not in GROUPS or known & GROUPS[item] else None
            within = 0.5 * 10.0 ** -wits.ITEMS[item][2] + 1e-6 * abs(value or 0.0)
            claim((frame[item] is None) == (value is None) and (value is None or abs(frame[item] - value) <= within),
                  f"item {item}: {frame[item]}, expected {value}")
        lowest, highest, mean = (reals[item] for item in ("0921", "0922", "0923"))
        ssi = 50.0 * (highest - lowest) / mean if mean > 0 and known & 8 else None
        claim((frame["0925"] is None) == (ssi is None or abs(ssi) >= 1e7) and
              (frame["0925"] is None or abs(frame["0925"] - ssi) <= 0.0501 + 1e-5 * abs(ssi)), f"item 0925: {frame['0925']}, expected {ssi}")
        claim(frame["0113"] is None and list(frame) == list(wits.ITEMS), "ROP is null, every item of the map is there")
    return None


def the_reader_is_strict():
    good = "&&\r\n01072\r\n01081600.25\r\n0113-9999\r\n!!\r\n"
    want = {"0107": 2, "0108": 1600.25, "0113": None}
    for text in (good, good.replace("\r\n", "\n"), good.replace("\r\n", "\r"), "x&&y\x07" + good, good[:-2], good + "tail"):
        try:
            claim(wits.one(text.encode()) == want, f"reads {text!r}")
        except wits.WitsError as error:
            claim(False, f"{error} in {text!r}")
    claim(wits.frames(b"") == [] and wits.frames(b"&& no frame") == [], "nothing is no frame")
    bad = {"no end": good.replace("!!", ""), "no lines": "&&\r\n!!\r\n", "an item twice": good.replace("0113-9999", "0107-9999"),
           "a strange item": good.replace("0113", "0114"), "out of order": good.replace("0107", "0120"),
           "decimals": good.replace("1600.25", "1600.2"), "a separator": good.replace("0108", "0108 "), "letters": good.replace("2\r", "two\r"),
           "exponent": good.replace("1600.25", "1.6e3"), "comma": good.replace(".25", ",25"), "nan": good.replace("1600.25", "nan"),
           "an empty line": good.replace("\r\n0113", "\r\n\r\n0113"), "a short line": good.replace("01072", "010"),
           "no value": good.replace("01072", "0107"), "minus nothing": good.replace("1600.25", "-0.00"), "zeros": good.replace("1600", "01600"),
           "an end in a line": good.replace("\r\n!!", "!!"), "frame in frame": good.replace("0113", "&&\r\n0113"), "plus": good.replace("1600", "+1600"),
           "blank behind": good.replace("1600.25", "1600.25 "), "other null": good.replace("-9999", "-999.25x"), "not ASCII": good.replace("2\r", "\u00b2\r")}
    for what, text in bad.items():
        try:
            wits.one(text.encode("utf-8"))
            claim(False, f"the reader refuses: {what}")
        except wits.WitsError:
            claim(True, "")


def main():
    os.makedirs(OUT, exist_ok=True)
    with tempfile.TemporaryDirectory() as directory:
        bytes_repeat(directory)
        schema_follows_the_layout()
        page_is_true()
        python_has_the_known_answers()
        for real, flags in (("float", ()), ("double", ("-DKELLY_DOUBLE",))):
            tool = build("link_tool-" + real, [os.path.join(ROOT, "tests", "link_tool.c"), *CODEC], *flags)
            if tool:
                codecs_agree(tool, real == "float")
                refusals_agree(tool, real == "float")
                damage_is_noticed(tool, real == "float")
                wits_reads_back(tool)
        the_reader_is_strict()
    print(f"{count[True]} passed, {count[False]} failed")
    return count[False] != 0


if __name__ == "__main__":
    sys.exit(main())
