"""python3 gen/protocol.py [--out ROOT]

The messages between a host and a board, stated once. Writes firmware/link/messages.h and messages.c, host/link_messages.py and
the page firmware/link/PROTOCOL.md below ROOT (default: this tree), the same bytes every time.

A change of MESSAGES or VALUES changes the schema number, and programs of different schemas refuse each other in the hello.
hello and the first two fields of its reply never change: they are how two programs find out that they differ.
"""
import argparse
import os
import sys
from collections import namedtuple

sys.dont_write_bytecode = True
ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))

HOST, BOARD = "host", "board"

# kind: u8 u16 u32 u64 f32 real text<N>, or the name of VALUES (a u8 within their range), or flag (0 or 1)
Field = namedtuple("Field", "name kind unit meaning")
Message = namedtuple("Message", "number name sender fields meaning")

# name: (prefix in C, [(number, name, meaning)])
VALUES = {
    "error": ("KELLY_ERR", [
        (1, "schema", "a hello of this schema has not come yet"),
        (2, "type", "no request has this number"),
        (3, "body", "the body does not fit the type, or holds a value that the type cannot have"),
        (4, "value", "a value that cannot be worked with"),
        (5, "refused", "the table refuses this case; the text says why"),
        (6, "no_case", "no case of this CRC is set"),
        (7, "order", "no such session, or a frame or index that is not next"),
        (8, "mode", "not what the board is doing"),
    ]),
    "watchdog": ("KELLY_WATCHDOG", [
        (0, "none", "a wedged step is not noticed"),
        (1, "software", "the tick interrupt watches"),
        (2, "hardware", "a timer of the part resets it"),
    ]),
    "status": ("KELLY_LINK_STATUS", [
        (0, "ok", "counted"),
        (1, "step", "step too long or too short for this draw"),
        (2, "range", "weight outside the fit of the table"),
        (3, "nonfinite", "the state left all bounds"),
        (4, "corrupt", "a number that must not change did, in the board's memory"),
    ]),
    "state": ("KELLY_STATE", [
        (0, "idle", "nothing runs"),
        (1, "campaign", "realisations are computed"),
        (2, "lockstep", "the plant waits for lock_step"),
        (3, "realtime", "the plant runs on the tick"),
    ]),
    "source": ("KELLY_SOURCE", [
        (0, "nominal", "the means of the case"),
        (1, "sample", "realisation `index` of `seed`"),
    ]),
    "mode": ("KELLY_MODE", [
        (2, "lockstep", "advance only when asked"),
        (3, "realtime", "advance on the board's tick"),
    ]),
    "policy": ("KELLY_POLICY", [
        (0, "hold", "go on at the last command"),
        (1, "ramp", "ramp the top down to 0 within ramp_ms"),
        (2, "stop", "stop the plant"),
    ]),
    "running": ("KELLY_RT", [
        (0, "running", "commands come"),
        (1, "hold", "the host is silent, the last command holds"),
        (2, "ramping", "the host is silent, the top ramps down"),
        (3, "stopped", "the plant stands still"),
    ]),
}


def _fields(text):
    """Lines `name.. kind [unit] meaning`: several names of one kind share a line, the meaning then says for all."""
    fields = []
    for line in text.strip().splitlines():
        names, kind, rest = line.strip().split(None, 2)
        unit, meaning = rest[1:].split("]", 1)
        fields += [Field(name, kind, unit, meaning.strip()) for name in names.split(",")]
    return tuple(fields)


SIGHT = """
    bit_speed real [rad/s] of the bit
    bit_torque real [N m] of the rock on the bit, negative while it resists
    f_bit real [N] weight as the rock feels it, not above 0
    surface_torque real [N m] eq. (S)
    axial_speed real [m/s] of the bit
    top_speed real [rad/s] of the top, now"""

MESSAGES = [
    Message(1, "hello", HOST, _fields("""
        schema u32 [] KELLY_LINK_SCHEMA of the host
        nonce u32 [] any number; the reply brings it back"""),
            "Who is there? The board drops what it was doing and is idle. Answered by hello_reply, whatever the schema."),
    Message(2, "hello_reply", BOARD, _fields("""
        schema u32 [] KELLY_LINK_SCHEMA of the board
        nonce u32 [] of the hello
        image_crc u32 [] CRC-32C of the image in flash
        image_size u32 [bytes] of what image_crc covers
        real_bytes u8 [] 4: the plant runs in float, 8: in double
        watchdog watchdog [] what notices a wedged step
        frame_max u16 [bytes] largest payload that the board takes
        tick_hz u32 [Hz] rate of the board's tick
        board text<24> [] name, that of linker/NAME.mk
        version text<16> [] KELLY_VERSION
        model text<40> [] id of the table"""),
            "What answers: the program, the string it was built for and where it runs."),
    Message(3, "error", BOARD, _fields("""
        code error [] what was wrong
        of_type u8 [] type of the request, 0 if none
        text text<80> [] the same for people"""),
            "A request that was not carried out, and changed nothing."),
    Message(4, "case_set", HOST, _fields("""
        fc real [N] weight on bit |f_c|
        mu real [m] bit-rock factor
        a1 real [s/rad] alpha_1
        a2 real [s2/rad2] alpha_2
        w0 real [rad/s] top speed
        f0 real [N] amplitude of the weight
        cov0,cov1,cov2,cov3,cov4 f32 [] coefficient of variation of fc, mu, a1, a2, w0 in turn, 0: not random
        limit real [] severity from which it counts as stick-slip
        step_ns u32 [ns] step
        ticks u32 [steps] duration
        window_first u32 [steps] first step that counts
        window_last u32 [steps] last step that counts
        torsional u8 [] modes of torsion
        axial u8 [] axial modes, the rigid one included
        rotating flag [] 1: starts rotating, 0: at rest
        drive_inertia real [kg m2] of a soft drive; 0: stiff
        drive_impedance real [N m s/rad] of a soft drive
        drive_hz real [Hz] of a soft drive"""),
            "The case of every run and plant from now on. Answered by case_reply."),
    Message(5, "case_reply", BOARD, _fields("""
        case_crc u32 [] CRC-32C of the body of case_set; names the case"""),
            "The case is set."),
    Message(6, "run", HOST, _fields("""
        case_crc u32 [] of the case
        seed u64 [] of the realisations
        first u32 [] index of the first
        count u32 [] how many; first + count is at most 4294967295"""),
            "Compute realisations first, first + 1, ... in order; replaces what was running. The last 8 results are kept: one of "
            "them is sent again at once when its index is asked for with the same case and seed. Answered by results."),
    Message(7, "result", BOARD, _fields("""
        job u32 [] CRC-32C of case_crc and seed, 12 bytes, little-endian
        index u32 [] of the realisation
        draw_crc u32 [] CRC-32C of the draw: fc, mu, a1, a2, w0 as five reals of the wire
        lowest real [rad/s] bit speed in the window
        highest real [rad/s] bit speed in the window
        mean real [rad/s] bit speed in the window
        ss real [] severity
        status status [] 0 counted, else why not: the values above are 0 then
        stuck flag [] severity above the limit
        liftoff flag [] the weight would have changed its sign"""),
            "One realisation. Seq 0."),
    Message(8, "status", BOARD, _fields("""
        state state [] what the board does
        next u32 [] index that is computed now
        end u32 [] one behind the last index of the run
        good u32 [] frames received
        bad u32 [] frames dropped"""),
            "A sign of life: after a hello every 100 ms while idle or in a campaign, at once in answer to stop, and at most every "
            "10 ms when a frame was dropped. Seq 0 but in the answer to stop."),
    Message(9, "stop", HOST, (),
            "Drop what runs; idle. The case stays. Answered by status."),
    Message(10, "plant_start", HOST, _fields("""
        case_crc u32 [] of the case
        source source [] of the draw
        seed u64 [] of the draw
        index u32 [] of the draw
        mode mode [] who drives time
        top_speed real [rad/s] of the top until commanded otherwise
        duration u32 [steps] 0: endless
        stream_ticks u32 [steps] an rt_sample every so many, 0: none
        command_ms u32 [ms] silence of the host after which the policy acts, 0: not watched
        policy policy [] what then happens
        ramp_ms u32 [ms] of the policy ramp
        overload_steps u32 [] test: one step in each of so many seconds is made longer
        overload_us u32 [us] test: by so much"""),
            "Start one string. The session is the seq of this request; the same seq again starts nothing. Answered by plant_reply."),
    Message(11, "plant_reply", BOARD, _fields("""
        session u32 [] seq of plant_start
        status status [] 0: it runs, else the draw cannot be run
        reason u8 [] 0, or the code of the error that names it best"""),
            "Whether the string runs."),
    Message(12, "lock_step", HOST, _fields("""
        session u32 []
        frame u32 [] 1, 2, 3, ...
        ticks u32 [steps] to advance, 1 or more
        top_speed real [rad/s] reached by an even ramp at the end of these steps
        weight real [N] weight on bit, above 0, at once"""),
            "Next frame (the last one + 1): command and advance. The last frame again: its answer again, nothing advances. "
            "Any other: error. Answered by lock_answer."),
    Message(13, "lock_answer", BOARD, _fields("""
        session u32 []
        frame u32 [] of lock_step
        tick u32 [steps] since the start""" + SIGHT + """
        sane flag [] 0: the state left all bounds, and the six values above are 0"""),
            "The string after those steps."),
    Message(14, "rt_command", HOST, _fields("""
        session u32 []
        number u32 [] 1, 2, 3, ...; one that is not above the last changes nothing
        top_speed real [rad/s] to reach
        ramp_ticks u32 [steps] within so many, 1 or more
        weight real [N] weight on bit, above 0, at once"""),
            "Set top speed and weight of a string in real time. Answered by rt_ack."),
    Message(15, "rt_ack", BOARD, _fields("""
        session u32 []
        number u32 [] of the command"""),
            "The command has been taken, now or before."),
    Message(16, "rt_sample", BOARD, _fields("""
        session u32 []
        tick u32 [steps] since the start""" + SIGHT + """
        late u32 [steps] whose tick came while the step before was at work, or begun a whole period late
        worst_late_us u32 [us] longest time from a tick to the start of its step
        load_permille u16 [] busy time of the last second
        state running [] who commands"""),
            "The string in real time. Seq 0."),
    Message(17, "rt_query", HOST, _fields("""
        session u32 []"""),
            "How is it going? Answered by rt_report."),
    Message(18, "rt_report", BOARD, _fields("""
        session u32 []
        tick u32 [steps] since the start
        late u32 [steps] whose tick came while the step before was at work, or begun a whole period late
        worst_late_us u32 [us] longest time from a tick to the start of its step
        load_permille u32 [] busy time since the start
        load_worst_permille u32 [] of the longest step, of one tick
        commands u32 [] taken
        timeouts u32 [] times that the host fell silent
        samples u32 [] sent
        unsane u32 [steps] after which the state was out of bounds
        state running [] who commands"""),
            "The books of a session. Also once unasked, with seq 0, at the end of its duration."),
    Message(19, "wits_query", HOST, (),
            "What would a rig display read? Answered by wits."),
    Message(20, "wits", BOARD, _fields("""
        text text<360> [] one WITS level 0 frame, && to !!"""),
            "One frame for a rig display; its items are listed in firmware/link/wits.h."),
]


def limits(kind):
    """-> (kind on the wire, least, largest value) of a field's kind; the length of a text is its largest."""
    if kind == "flag":
        return "u8", 0, 1
    if kind in VALUES:
        numbers = [number for number, _, _ in VALUES[kind][1]]
        return "u8", min(numbers), max(numbers)
    if kind.startswith("text<"):
        return "text", 0, int(kind[5:-1])
    return kind, 0, {"u8": 255, "u16": 65535, "u32": 2 ** 32 - 1, "u64": 2 ** 64 - 1, "f32": 0, "real": 0}[kind]


WIRE_BYTES = {"u8": 1, "u16": 2, "u32": 4, "u64": 8, "f32": 4, "real": 8}


def largest_body(message):
    return sum(WIRE_BYTES.get(wire, 2 + high) for wire, _, high in (limits(f.kind) for f in message.fields))


def canonical():
    """What the schema number is the CRC-32C of: layout and values, no prose."""
    lines = ["frame 00 COBS(u8 type, u32 seq, body, u32 crc32c) 00"]
    for m in MESSAGES:
        fields = ", ".join("{} {} {}..{}".format(f.name, *limits(f.kind)) for f in m.fields)
        lines.append(f"{m.number} {m.name} {m.sender}: {fields}")
    for name, (_, values) in VALUES.items():
        lines.append(f"{name}: " + ", ".join(f"{number} {value}" for number, value, _ in values))
    return "\n".join(lines) + "\n"


def main(argv):
    parser = argparse.ArgumentParser(prog="protocol.py", description="Messages -> C and Python codecs and their page.")
    parser.add_argument("--out", metavar="ROOT", default=ROOT)
    root = parser.parse_args(argv).out
    import emit_link
    for path, text in emit_link.emit().items():
        path = os.path.join(root, path)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "w", encoding="ascii", newline="\n") as file:
            file.write(text)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
