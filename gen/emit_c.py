"""The certified table as C: NAME.c (a `kelly_table`) and NAME_shapes.c (a `kelly_shapes`), see string_model.h.

Literals are hexadecimal, so the compiler rounds each of them once, to float or to double.
"""
import math
import struct

SCHEMA = 2          # KELLY_SCHEMA of string_model.h
COVS = ("fc", "mu", "a1", "a2", "w0")


def emit(well, bars, reduction, stable, certificate, source):
    """-> (text of NAME.c, text of NAME_shapes.c). `source` is the well file's name without its directory."""
    arrays = _arrays(reduction)
    shapes = _shape_arrays(bars, reduction)
    scalars = _scalars(well, bars, reduction)
    counts = _counts(well, reduction)
    identity = f"{well.name}-{_crc32c(_bytes(counts, scalars, arrays, shapes)):08x}"
    table = (_banner(well, source, certificate) + _guards(well, stable)
             + "".join(_array(*item) for item in arrays)
             + _table(identity, counts, scalars, _impedance(well), [_head_crc(identity, counts, scalars, _impedance(well)), _held_crc(arrays)]))
    return table, _shapes_banner(well, source) + _shapes(identity, bars, shapes, reduction)


# ---- values, in the order of the CRC

def _counts(well, reduction):
    return {
        "torsional": reduction.free_w2.shape[0], "axial": reduction.axial_free_w2.shape[0], "degree": reduction.degree,
        "nodes": reduction.nodes, "step_ns": well.step_ns, "ticks": well.ticks, "window_first": well.window_first,
        "window_last": well.window_last, "run_torsional": well.torsional, "run_axial": well.axial,
        "rotating": int(well.rotating),
    }


def _scalars(well, bars, reduction):
    return {
        "fc_min": reduction.fc_min, "fc_max": reduction.fc_max,
        "fc_mid": reduction.fc_mid, "fc_scale": reduction.fc_scale,
        "alpha": well.alpha, "beta": well.beta, "inertia": bars.inertia,
        "fc": well.fc, "mu": well.mu, "a1": well.a1, "a2": well.a2, "w0": well.w0, "f0": well.f0, "limit": well.limit,
        **{"cov_" + name: value for name, value in zip(COVS, well.cov)},
    }


def _polynomials(fit):
    """[degree + 1, ...] -> list of polynomials p[0..degree], last axes in order."""
    flat = fit.reshape(fit.shape[0], -1)
    return [flat[:, i].tolist() for i in range(flat.shape[1])]


def _arrays(reduction):
    """(name, comment, list of rows); a row is one polynomial, or one number."""
    fit = reduction.fit
    return [
        ("w2", "squared natural frequency, torsion [rad2/s2]", _polynomials(fit["w2"])),
        ("b", "mode shape at the bit [kg^-1/2 m^-1]", _polynomials(fit["b"])),
        ("d", "phi' M 1 [kg^1/2 m]", _polynomials(fit["d"])),
        ("axial_w2", "squared natural frequency, axial [rad2/s2]; mode 1 is rigid", _polynomials(fit["axial_w2"])),
        ("axial_b", "axial mode shape at the bit [kg^-1/2]", _polynomials(fit["axial_b"])),
        ("free_w2", "without prestress [rad2/s2]", [[v] for v in reduction.free_w2.tolist()]),
        ("axial_free_w2", "without prestress [rad2/s2]", [[v] for v in reduction.axial_free_w2.tolist()]),
    ]


def _shape_arrays(bars, reduction):
    return [("x", [[v] for v in bars.x.tolist()])] + [
        (name, _polynomials(reduction.fit[name])) for name in ("twist", "axial", "twist_gram", "axial_gram")]


def _impedance(well):
    """Characteristic impedance of the uppermost section, for torsion. Follows from the rest: not in the CRC."""
    top = well.sections[0]
    return math.pi / 32.0 * (top.outer**4 - top.inner**4) * math.sqrt(well.density * well.shear)


def _bytes(counts, scalars, arrays, shapes):
    numbers = list(scalars.values())
    for *_, rows in arrays + shapes:
        numbers += [value for row in rows for value in row]
    return struct.pack(f"<{len(counts)}I", *counts.values()) + struct.pack(f"<{len(numbers)}d", *numbers)


# The table checks itself where it lies (string_model.c): CRCs of the values as C holds them, -> (of a float build, of a double build).

def _held(numbers, kind):
    return struct.pack(f"<{len(numbers)}{kind}", *(value + 0.0 for value in numbers))


def _head_crc(identity, counts, scalars, impedance):
    """In the order of the struct; the drive of a table is stiff."""
    values = {**scalars, "impedance": impedance}

    def head(kind):
        real = lambda *names: _held([values[name] for name in names], kind)   # noqa: E731
        whole = lambda form, *names: struct.pack(f"<{len(names)}{form}", *(counts[name] for name in names))   # noqa: E731
        return (whole("H", "torsional", "axial", "degree", "nodes")
                + real("fc_min", "fc_max", "fc_mid", "fc_scale", "alpha", "beta", "inertia", "impedance", "fc", "mu", "a1", "a2", "w0", "f0")
                + _held([values["cov_" + name] for name in COVS], "f") + real("limit")
                + whole("I", "step_ns", "ticks", "window_first", "window_last") + whole("B", "run_torsional", "run_axial", "rotating")
                + _held([0.0, 0.0, 0.0], kind) + identity.encode())

    return tuple(_crc32c(head(kind)) for kind in "fd")


def _held_crc(arrays):
    numbers = [value for *_, rows in arrays for row in rows for value in row]
    return tuple(_crc32c(_held(numbers, kind)) for kind in "fd")


def _crc(name, pair):
    return f"    .{name} = sizeof(real) == sizeof(float) ? 0x{pair[0]:08x}u : 0x{pair[1]:08x}u,\n"


def _crc32c(data):
    """Castagnoli, reflected; "123456789" gives E3069283."""
    table = []
    for byte in range(256):
        for _ in range(8):
            byte = byte >> 1 ^ (0x82F63B78 if byte & 1 else 0)
        table.append(byte)
    crc = 0xFFFFFFFF
    for byte in data:
        crc = crc >> 8 ^ table[(crc ^ byte) & 255]
    return crc ^ 0xFFFFFFFF


# ---- C

def _hex(value):
    """12.0 -> "0x1.8p+3": float.hex without its trailing zeros. One zero: -0 and 0 would differ in the bytes."""
    mantissa, exponent = (value + 0.0).hex().split("p")
    return (mantissa.rstrip("0").rstrip(".") if "." in mantissa else mantissa) + "p" + exponent


def _real(value):
    return f"R({_hex(value)})"


def _banner(well, source, certificate):
    lines = [f'The drill string "{well.name}" as a table. GENERATED, do not edit.', "",
             f"Generator  gen/ (schema {SCHEMA})", f"Command    python3 gen {source}", "",
             "Inputs, as the file has them"]
    lines += [f"  {key} = {text}" for key, text in well.inputs]
    lines += ["", "Certificate, proved before this file was written"]
    lines += ["  " + line for line in certificate]
    return _comment(lines)


def _comment(lines):
    return "/* " + "\n".join([lines[0]] + [(" * " + line).rstrip() for line in lines[1:]]) + "\n */\n"


SCHEMA_CHECK = f"""#include "../string_model.h"

#if KELLY_SCHEMA != {SCHEMA}u
#error "this table was generated for schema {SCHEMA}: run `make tables`"
#endif

"""


def _guards(well, stable):
    duration = well.step_ns * well.ticks
    return SCHEMA_CHECK + f"""/* The step and what it was checked for; edit the well file, not this. */
#define STEP_NS      {well.step_ns}u
#define TICKS        {well.ticks}u
#define RATE_PER_S   {int(stable.rate)}u       /* fastest rate of a realisation, exceeded with probability 1e-6 [1/s] */
#define FASTEST_MRAD {round(stable.fastest * 1000.0)}u      /* largest natural frequency of a run [0.001 rad/s] */

_Static_assert((uint64_t)STEP_NS * TICKS == {duration}u, "step and duration do not belong together: regenerate");
_Static_assert((uint64_t)STEP_NS * RATE_PER_S <= 2785000000u, "unsafe step: RK4 needs h rate <= 2.785");
_Static_assert((uint64_t)STEP_NS * FASTEST_MRAD <= 2800000000000u, "unsafe step: RK4 needs h w <= 2.8");

"""


def _array(name, comment, rows):
    single = len(rows[0]) == 1
    text = f"/* {comment} */\nstatic const real {name}[] = {{\n"
    for i, row in enumerate(rows):
        text += "" if single else f"    /* mode {i + 1} */\n"
        text += "".join(f"    {_real(value) + ',':31} /* {value + 0.0!r} */\n" for value in row)
    return text + "};\n\n"


def _field(name, value, indent="    "):
    text = f"{indent}.{name} = {_real(value)},"
    return f"{text:48} /* {value!r} */\n"


def _table(identity, counts, scalars, impedance, crcs):
    text = "const kelly_table kelly_string = {\n    .schema = KELLY_SCHEMA,\n    .real_bytes = sizeof(real),\n"
    text += _crc("head_crc", crcs[0]) + _crc("arrays_crc", crcs[1])
    text += f'    .id = "{identity}",\n'
    text += "".join(f"    .{name} = {counts[name]},\n" for name in ("torsional", "axial", "degree", "nodes"))
    text += "".join(_field(name, scalars[name]) for name in
                    ("fc_min", "fc_max", "fc_mid", "fc_scale", "alpha", "beta", "inertia"))
    text += _field("impedance", impedance)
    text += "".join(f"    .{name} = {name},\n" for name in
                    ("w2", "b", "d", "axial_w2", "axial_b", "free_w2", "axial_free_w2"))
    text += "    .nominal = {\n" + "".join(_field(name, scalars[name], " " * 8) for name in
                                           ("fc", "mu", "a1", "a2", "w0", "f0", "limit"))
    covs = ",\n                 ".join(_hex(scalars["cov_" + name]) + "f" for name in COVS)
    plain = ", ".join(repr(scalars["cov_" + name]) for name in COVS)
    text += f"        /* {', '.join(COVS)}: {plain} */\n        .cov = {{ {covs} }},\n"
    text += "        .step_ns = STEP_NS,\n        .ticks = TICKS,\n"
    text += "".join(f"        .{name} = {counts[name]}u,\n" for name in ("window_first", "window_last"))
    text += f"        .torsional = {counts['run_torsional']},\n        .axial = {counts['run_axial']},\n"
    return text + f"        .rotating = {counts['rotating']},\n    }},\n}};\n"


def _shapes_banner(well, source):
    return _comment([f'Mode shapes of the drill string "{well.name}" at the nodes. GENERATED, do not edit.', "",
                     f"Generator  gen/ (schema {SCHEMA})", f"Command    python3 gen {source}", "",
                     "Inputs and certificate: in the table of the same id."]) + SCHEMA_CHECK


def _shapes(identity, bars, shapes, reduction):
    text = ""
    for name, rows in shapes:
        text += f"static const real {name}[] = {{\n"
        for i, row in enumerate(rows):
            if name in ("twist", "axial") and i % reduction.nodes == 0:
                text += f"    /* mode {i // reduction.nodes + 1} */\n"
            text += "    " + ", ".join(_real(value) for value in row) + ",\n"
        text += "};\n\n"
    text += "const kelly_shapes kelly_string_shapes = {\n    .schema = KELLY_SCHEMA,\n    .real_bytes = sizeof(real),\n"
    text += _crc("crc", _held_crc(shapes))
    text += f'    .id = "{identity}",\n' + "".join(f"    .{name} = {name},\n" for name, _ in shapes)
    return text + "};\n"
