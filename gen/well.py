"""The well file: TOML text in, a checked `Well` in SI units out. Nothing else in gen/ knows a key or a unit.

Numbers are read as decimals, so that "is 50 s a whole number of 1 ms steps" is decided exactly, and the
value a message quotes is the value the user wrote.
"""
import decimal
import difflib
import json
import math
import re
import tomllib
from dataclasses import dataclass
from decimal import Decimal

MODES_MAX = 20        # KELLY_MODES_MAX of string_model.h
ELEMENTS_MAX = 1000   # of the whole string: keeps the shapes file within a few MB
FC_MIN = 1000.0       # [N] lower end of every fit
STEPS_MOST = 4 * 10**9   # of a run: STEPS_MOST of host/host.h


class WellError(Exception):
    """One line for the user: where, what stands there, what would be right."""

    def __init__(self, want, path=(), value=None, missing=False):
        super().__init__(want)
        self.want, self.path, self.value, self.missing = want, tuple(path), value, missing


@dataclass(frozen=True)
class Section:
    name: str
    length: float          # [m]
    outer: float           # outside diameter [m]
    inner: float           # inside diameter [m]
    elements: int


@dataclass(frozen=True)
class Well:
    name: str
    sections: tuple        # of Section, from the top down
    youngs: float          # [Pa]
    shear: float           # [Pa]
    density: float         # [kg/m3]
    alpha: float           # mass-proportional damping [1/s]
    beta: float            # stiffness-proportional damping [s]
    gravity: float         # [m/s2]
    torsional: int         # modes a run uses
    axial: int             # the rigid one included
    w0: float              # mean top speed [rad/s]
    fc: float              # mean weight on bit |f_c| [N]
    f0: float              # amplitude of the weight [N]
    mu: float              # [m]
    a1: float              # [s/rad]
    a2: float              # [s2/rad2]
    cov: tuple             # of fc, mu, a1, a2, w0: the order of KELLY_PARAMETERS
    limit: float           # severity above which a realisation counts as stick-slip
    step_ns: int
    ticks: int
    window_first: int      # [ticks]
    window_last: int
    rotating: bool
    inputs: tuple          # (key, text) of every physical input as written, for the banner

    @property
    def elements(self):
        return sum(s.elements for s in self.sections)


# Key -> SI: value * multiplier / divisor, in that order (the host's --rpm and --wob do the same products).
RAD_S_PER_RPM = 0.10471975511965977
SCALE = {
    "m": (1.0, 1.0), "mm": (1.0, 1000.0), "GPa": (1e9, 1.0), "kg_m3": (1.0, 1.0), "per_s": (1.0, 1.0),
    "s": (1.0, 1.0), "m_s2": (1.0, 1.0), "kN": (1000.0, 1.0), "rpm": (RAD_S_PER_RPM, 1.0), "": (1.0, 1.0),
    # field units by definition: 1 ft = 0.3048 m, 1 in = 25.4 mm, 1 lbm = 0.45359237 kg, 1 lbf = 1 lbm * 9.80665 m/s2;
    # each ratio of two numbers that a double holds exactly
    "ft": (3048.0, 10000.0), "in": (254.0, 10000.0), "klbf": (44482216152605.0, 1e10),
    "Mpsi": (444822161526050.0, 64516.0), "lbm_ft3": (453592370000.0, 28316846592.0),
}


@dataclass(frozen=True)
class Number:
    """A number of the file. `keys` maps each accepted key to its unit; exactly one of them must be there."""
    field: str
    keys: dict
    low: float             # bounds in the unit of the first key
    high: float
    whole: bool = False


def _number(field, key, unit, low, high, whole=False):
    return Number(field, {key: unit}, low, high, whole)


def _either(field, stem, unit, other, low, high):
    """A quantity in SI or in field units: the unit is the end of the key. The bounds are in SI."""
    return Number(field, {f"{stem}_{unit}": unit, f"{stem}_{other}": other}, low, high)


# The bounds are wide: they catch a value in the wrong unit and keep float arithmetic far from overflow.
SECTION = (
    _either("length", "length", "m", "ft", 0.1, 20000.0),
    _either("outer", "outer_diameter", "mm", "in", 1.0, 2000.0),
    _either("inner", "inner_diameter", "mm", "in", 0.0, 2000.0),
    _number("elements", "elements", "", 1, ELEMENTS_MAX, whole=True),
)
TABLES = {
    "material": (_either("youngs", "youngs_modulus", "GPa", "Mpsi", 1.0, 1000.0),
                 _either("shear", "shear_modulus", "GPa", "Mpsi", 0.3, 1000.0),
                 _either("density", "density", "kg_m3", "lbm_ft3", 100.0, 30000.0)),
    "damping": (_number("alpha", "mass_per_s", "per_s", 0.0, 100.0),
                _number("beta", "stiffness_s", "s", 0.0, 1.0)),
    "environment": (_number("gravity", "gravity_m_s2", "m_s2", 0.0, 100.0),),
    "modes": (_number("torsional", "torsional", "", 1, MODES_MAX, whole=True),
              _number("axial", "axial", "", 1, MODES_MAX, whole=True)),
    # 2..500 kN: the fit runs from 1 to 1000 kN and must hold half and twice the nominal weight
    "case": (_number("w0", "rpm", "rpm", 0.1, 1000.0),
             _either("fc", "wob", "kN", "klbf", 2.0, 500.0),
             _either("f0", "wob_amplitude", "kN", "klbf", 0.0, 1000.0),
             _number("mu", "mu", "", 1e-6, 10.0),
             _number("a1", "alpha1", "", 1e-6, 1000.0),
             _number("a2", "alpha2", "", 1e-6, 1000.0)),
    "uncertainty": tuple(_number(field, key, "", 0.0, 0.5) for field, key in
                         (("w0", "rpm"), ("fc", "wob"), ("mu", "mu"), ("a1", "alpha1"), ("a2", "alpha2"))),
}
RUN_KEYS = ("step_s", "duration_s", "window_s", "severity_limit", "start")


def parse(text):
    """Text of a well file -> Well. Raises WellError."""
    try:
        top = tomllib.loads(text, parse_float=Decimal)
    except RecursionError:
        raise WellError("expected a TOML file, this one is nested too deeply") from None
    except decimal.DecimalException:
        raise WellError("expected a TOML file whose numbers a computer can hold") from None
    except ValueError as error:   # tomllib's own error is one of these
        raise WellError("expected a TOML file: " + " ".join(str(error).split())) from None
    _only_keys(top, ("name", "section", *TABLES, "run"), ())
    inputs = []
    name = _string(top, "name", (), r"[A-Za-z0-9][A-Za-z0-9_-]{0,31}",
                   "1 to 32 letters, digits, _ or - (the generated files are called after it)")
    if name.endswith("_shapes"):
        raise WellError('expected a name that does not end in "_shapes", or two files would collide', ("name",), name)
    sections = _sections(top, inputs)
    tables = {table: _numbers(_table(top, table), numbers, (table,), inputs)
              for table, numbers in TABLES.items()}
    run = _run(_table(top, "run"), inputs)
    cov = tables.pop("uncertainty")
    values = {field: value for table in tables.values() for field, value in table.items()}
    well = Well(name=name, sections=sections, cov=tuple(cov[p] for p in ("fc", "mu", "a1", "a2", "w0")),
                inputs=tuple(inputs), **values, **run)
    _check_modes(well)
    return well


def _check_modes(well):
    if well.elements > ELEMENTS_MAX:
        raise WellError(f"expected at most {ELEMENTS_MAX} in all sections together, these are {well.elements}",
                        ("section", len(well.sections), "elements"), well.sections[-1].elements)
    for key, asked, freedom in (("torsional", well.torsional, well.elements), ("axial", well.axial, well.elements + 1)):
        if asked > freedom:
            raise WellError(f"expected 1 to {freedom}, the model has {freedom} {key} degrees of freedom",
                            ("modes", key), asked)


def lift_off(well):
    """What to tell the owner of a well whose weight changes its sign at the means, or None. The model leaves out what the bit then does."""
    if well.fc >= 1.01 * well.f0:
        return None
    key, text = next(item for item in well.inputs if item[0].startswith("case.wob_amplitude_"))
    return WellError("warning: at the means the weight changes its sign (|fc| < 1.01 f0): the bit would lift off, which the model leaves out; "
                     "it stays on below 0.99 of the weight", key.split("."), Decimal(text))


# ---- pieces of the file

def _only_keys(table, known, path):
    for key in table:
        if key not in known:
            near = difflib.get_close_matches(key, known, 1)
            hint = f"did you mean {near[0]}?" if near else "known here: " + ", ".join(known)
            raise WellError("unknown key, " + hint, (*path, key), table[key])


def _table(top, key):
    if key not in top:
        raise WellError(f"expected a table [{key}]", (key,), missing=True)
    if not isinstance(top[key], dict):
        raise WellError(f"expected a table [{key}]", (key,), top[key])
    return top[key]


def _string(table, key, path, pattern, want):
    if key not in table:
        raise WellError("expected " + want, (*path, key), missing=True)
    if not isinstance(table[key], str) or not re.fullmatch(pattern, table[key]):
        raise WellError("expected " + want, (*path, key), table[key])
    return table[key]


def _sections(top, inputs):
    if "section" not in top:
        raise WellError("expected one [[section]] or more, from the top down", ("section",), missing=True)
    tables = top["section"]
    if not isinstance(tables, list) or not tables or not all(isinstance(t, dict) for t in tables):
        raise WellError("expected one [[section]] or more, from the top down", ("section",), tables)
    return tuple(_section(table, ("section", i + 1), inputs) for i, table in enumerate(tables))


def _section(table, path, inputs):
    _only_keys(table, ("name", *(key for n in SECTION for key in n.keys)), path)
    # the name ends up in a C comment: no star, no backslash, no trigraph
    name = _string(table, "name", path, r"[A-Za-z0-9 _.,()/+-]{1,40}", "1 to 40 letters, digits, spaces or _.,()/+-")
    inputs.append((_dotted((*path, "name")), json.dumps(name)))
    values = _numbers({k: v for k, v in table.items() if k != "name"}, SECTION, path, inputs)
    if values["inner"] >= values["outer"]:
        key = next(k for k in SECTION[2].keys if k in table)
        outer = next(k for k in SECTION[1].keys if k in table)
        raise WellError(f"expected less than {outer} = {table[outer]}", (*path, key), table[key])
    return Section(name=name, **values)


def _numbers(table, numbers, path, inputs):
    _only_keys(table, tuple(key for n in numbers for key in n.keys), path)
    return {n.field: _take(table, n, path, inputs) for n in numbers}


def _take(table, number, path, inputs):
    """The one key of `number` that the table holds, checked and in SI."""
    first = next(iter(number.keys))
    found = [key for key in number.keys if key in table]
    if not found:
        others = "".join(f" (or {key})" for key in number.keys if key != first)
        raise WellError("expected " + _range_text(number, first) + others, (*path, first), missing=True)
    if len(found) > 1:
        raise WellError(f"expected only one of {', '.join(found)}", (*path, found[1]), table[found[1]])
    key = found[0]
    value = _finite(table[key], number.whole)
    if value is None or not _in_range(value, number, key):
        raise WellError("expected " + _range_text(number, key), (*path, key), table[key])
    inputs.append((_dotted((*path, key)), str(table[key])))
    return value if number.whole else _si(value, number.keys[key])


def _finite(value, whole=False):
    """int or float, or None where the value is not a number at all (a bool is none, nor is NaN or 1e400)."""
    if isinstance(value, bool) or not isinstance(value, int if whole else (int, Decimal)):
        return None
    if whole:
        return value
    try:
        value = float(value)
    except OverflowError:
        return None
    return value if math.isfinite(value) else None


def _si(value, unit):
    multiplier, divisor = SCALE[unit]
    return value * multiplier / divisor


def _bounds(number, key):
    """Bounds in the unit of `key`."""
    first = next(iter(number.keys))
    if key == first:
        return number.low, number.high
    multiplier, divisor = SCALE[number.keys[key]]
    return tuple(_si(bound, number.keys[first]) * divisor / multiplier for bound in (number.low, number.high))


def _in_range(value, number, key):
    low, high = _bounds(number, key)
    return low <= value <= high


def _range_text(number, key):
    low, high = _bounds(number, key)
    unit = "" if number.keys[key] in ("", "rpm") else " " + number.keys[key].replace("_", "/", 1)
    return f"{'a whole number' if number.whole else 'a number'} from {low:g} to {high:g}{unit}"


# ---- the time grid

def _run(table, inputs):
    path = ("run",)
    _only_keys(table, RUN_KEYS, path)
    for key in RUN_KEYS:
        if key not in table:
            raise WellError("expected a value for this key", (*path, key), missing=True)
    step = _whole(table["step_s"], Decimal("1e-9"), (*path, "step_s"), 1000, 1000000000,
                  "a whole number of nanoseconds from 0.000001 to 1 s")
    step_s = Decimal(step).scaleb(-9)
    multiple = f"a multiple of step_s = {table['step_s']}"
    ticks = _whole(table["duration_s"], step_s, (*path, "duration_s"), 1, STEPS_MOST,
                   f"{multiple}, above 0 and at most {STEPS_MOST} steps")
    window = table["window_s"]
    if not isinstance(window, list) or len(window) != 2:
        raise WellError("expected [first, last] in seconds", (*path, "window_s"), window)
    want = f"two times from 0 to duration_s = {table['duration_s']}, each {multiple}"
    first, last = (_whole(t, step_s, (*path, "window_s"), 0, ticks, want, window) for t in window)
    if not first < last:
        raise WellError("expected first < last", (*path, "window_s"), window)
    limit = Number("limit", {"severity_limit": ""}, 0.0, 10.0)
    limit = _take(table, limit, path, [])
    start = _string(table, "start", path, "rest|rotating", '"rest" or "rotating"')
    inputs.extend((_dotted((*path, key)), show(table[key])) for key in RUN_KEYS)
    return {"step_ns": step, "ticks": ticks, "window_first": first, "window_last": last, "limit": limit,
            "rotating": start == "rotating"}


def _whole(value, unit, path, low, high, want, shown=None):
    """value / unit as an exact whole number in low..high."""
    finite = _finite(value)
    shown = value if shown is None else shown
    if finite is None or not 0.0 <= finite <= 1e10 or len(Decimal(value).as_tuple().digits) > 20:
        raise WellError("expected " + want, path, shown)
    count, rest = divmod(Decimal(value), unit)
    if rest != 0 or not low <= count <= high:
        raise WellError("expected " + want, path, shown)
    return int(count)


# ---- messages

def _dotted(path):
    """("section", 2, "length_m") -> "section[2].length_m"."""
    text = ""
    for part in path:
        text += f"[{part}]" if isinstance(part, int) else ("." if text else "") + part
    return text


def show(value):
    """A value of the file as the user would know it again, on one line."""
    if isinstance(value, Decimal):
        return str(value)
    if isinstance(value, list):
        text = "[" + ", ".join(show(v) for v in value) + "]"
    elif isinstance(value, dict):
        text = "{" + ", ".join(f"{k} = {show(v)}" for k, v in value.items()) + "}"
    else:
        try:
            text = json.dumps(value, default=str)
        except ValueError:            # an integer too long to print
            text = "(a very long number)"
    return text if len(text) <= 60 else text[:57] + "..."


def _bare(key):
    """A key without the blanks and quotes around it. (A pattern with a part for each takes minutes over a long line of blanks.)"""
    return key.strip().removeprefix('"').removesuffix('"').removeprefix("'").removesuffix("'")


def _line_of(text, path):
    """Line of the key in the text, 0 if it is written in a way that this short scan does not follow."""
    if not path:
        return 0
    *table, key = (path if not isinstance(path[-1], int) else (*path, ""))
    current, counts = [], {}
    for number, line in enumerate(text.splitlines(), 1):
        header = re.match(r"\s*(\[\[?)\s*([A-Za-z0-9_-]+)\s*\]", line)
        if header:
            current = [header[2]]
            if header[1] == "[[":
                counts[header[2]] = counts.get(header[2], 0) + 1
                current.append(counts[header[2]])
            if list(path) == current or list(path) == current[:1]:
                return number
        if current == table and "=" in line and _bare(line.partition("=")[0]) == key:
            return number
    return 0


def message(error, file, text=""):
    """The line that the user sees."""
    where = file
    line = _line_of(text, error.path) or (_line_of(text, error.path[:-1]) if error.missing else 0)
    if line:
        where += f":{line}"
    if not error.path:
        return f"kelly gen: {where}: {error.want}"
    value = "(missing)" if error.missing else show(error.value)
    key = _dotted(error.path)
    return f"kelly gen: {where}: {key if key.isprintable() else ascii(key)} = {value}: {error.want}"
