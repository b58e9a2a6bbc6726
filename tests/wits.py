"""A strict reader of WITS level 0, written from the format and not from firmware/link/wits.c.

frames(bytes) -> [{item: number, or None for null}, ...]; one(bytes) -> the only frame. Malformed: WitsError says what.
Between frames anything may stand; lines end with CR, LF or CR LF.
"""
import re

# item: (name, unit, decimals)
ITEMS = {
    "0105": ("date", "YYMMDD", 0), "0106": ("time", "HHMMSS", 0), "0107": ("activity", "", 0), "0108": ("bit depth", "m", 2),
    "0113": ("ROP", "m/h", 2), "0116": ("surface WOB, mean", "kdaN", 3), "0117": ("surface WOB, largest", "kdaN", 3),
    "0118": ("surface torque, mean", "kN m", 3), "0119": ("surface torque, largest", "kN m", 3), "0120": ("surface speed", "rpm", 0),
    "0915": ("downhole WOB, mean", "kdaN", 3), "0916": ("downhole WOB, largest", "kdaN", 3),
    "0917": ("downhole torque, mean", "kN m", 3), "0918": ("downhole torque, largest", "kN m", 3),
    "0921": ("bit speed, lowest", "rpm", 2), "0922": ("bit speed, highest", "rpm", 2), "0923": ("bit speed, mean", "rpm", 2),
    "0924": ("severity", "", 3), "0925": ("stick-slip index", "%", 1), "0926": ("P(stick-slip)", "", 4), "0927": ("realisations", "", 0),
}
DIGITS = {"0105": 6, "0106": 6}     # written with leading zeros
END = r"(?:\r\n|\r|\n)"
NULL = "-9999"
LONGEST = 1024


class WitsError(ValueError):
    pass


def _value(item, text):
    decimals = ITEMS[item][2]
    if text == NULL:
        return None
    fraction = r"\.[0-9]{%d}" % decimals if decimals else ""
    whole = "[0-9]{%d}" % DIGITS[item] if item in DIGITS else "(?:0|[1-9][0-9]*)"
    if not re.fullmatch("-?" + whole + fraction, text):
        raise WitsError(f"item {item}: not a number with {decimals} decimals: {text!r}")
    if text.startswith("-") and not re.search("[1-9]", text):
        raise WitsError(f"item {item}: a minus before nothing: {text!r}")
    return float(text) if decimals else int(text)


def _frame(lines):
    values = {}
    for line in lines:
        item, text = line[:4], line[4:]
        if item not in ITEMS:
            raise WitsError(f"not an item of the map: {line!r}")
        if item in values:
            raise WitsError(f"item {item} comes twice")
        values[item] = _value(item, text)
    if list(values) != sorted(values):
        raise WitsError("the items are out of order")
    if not values:
        raise WitsError("a frame without items")
    return values


def frames(data):
    try:
        text = bytes(data).decode("ascii")
    except UnicodeDecodeError as error:
        raise WitsError(f"byte {error.start} is not ASCII") from None
    found, at = [], 0
    while begin := re.compile("&&" + END).search(text, at):
        end = re.compile("!!(?:" + END + "|$)").search(text, begin.end())
        if not end:
            raise WitsError("a frame without its end !!")
        body = text[begin.end():end.start()]
        if len(body) > LONGEST:
            raise WitsError("a frame that is too long")
        if body and not re.search(END + "$", body):
            raise WitsError("the end !! is not on a line of its own")
        found.append(_frame(re.split(END, body)[:-1] if body else []))
        at = end.end()
    return found


def one(data):
    found = frames(data)
    if len(found) != 1:
        raise WitsError(f"{len(found)} frames where one was expected")
    return found[0]
