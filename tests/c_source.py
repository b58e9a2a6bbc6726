"""c_source - functions, loops and function pointers of a C file in this tree's style, without a compiler.

A function is what stands before a brace at the outermost level and ends in a parameter list. A loop is bounded in sight where
its condition compares a variable with something that the loop does not change, and every turn moves that variable towards it, by
a step that is not 0, and the type of the variable does not end before:
`for (k = 0; k < n; k++)`, `while (n-- > 0)`, `while (p < end) { ...; p++; }`. All else asks for a reason.
"""
import functools
import os
import re

NAME = r"[A-Za-z_]\w*"
COMPARES = re.compile(rf"^\(*(\+\+|--)?({NAME}(?:(?:->|\.){NAME})*)(\+\+|--)?(?: [-+] \w+)? (<=|<|>=|>|!=) (.+)$")
TYPE = r"\b(?:real|wide|vreal|float|double|unsigned|signed|int|long|short|char|size_t|ptrdiff_t|u?int(?:8|16|32|64)_t)\b"
NUMBER = re.compile(r"(0[xX][0-9a-fA-F]+|\d+)[uUlL]*$")


def blanked(text):
    """Comments, strings, characters and directives as blanks; every line stays where it is."""
    def blank(match):
        return re.sub(r"[^\n]", " ", match[0])
    text = re.sub(r'/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'', blank, text, flags=re.S)
    return re.sub(r"^[ \t]*#(?:[^\n]*\\\n)*[^\n]*", blank, text, flags=re.M)


def closing(text, at):
    """Index of the bracket that ends the one at `at`."""
    pairs = {"(": ")", "{": "}", "[": "]"}
    depth = 0
    for k in range(at, len(text)):
        if text[k] == text[at]:
            depth += 1
        elif text[k] == pairs[text[at]]:
            depth -= 1
            if depth == 0:
                return k
    return len(text) - 1


class Function:
    def __init__(self, name, first, last):
        self.name, self.first, self.last, self.lines = name, first, last, last - first + 1


class Loop:
    def __init__(self, line, bounded):
        self.line, self.bounded = line, bounded


class Source:
    def __init__(self, text):
        self.text, self.code = text, blanked(text)
        self.functions = list(self.find_functions())
        self.loops = list(self.find_loops())
        self.function_pointers = [self.line_of(m.start()) for m in re.finditer(r"\(\s*\*\s*(?:const\s*|volatile\s*)*\w*\s*(?:\[\w*\])?\)\s*\(", self.code)
                                  if not re.search(r"[=,(]\s*$|return\s*$", self.code[:m.start()])]

    def line_of(self, at):
        return self.code.count("\n", 0, at) + 1

    def line(self, number):
        lines = self.text.splitlines()
        return lines[number - 1] if 0 < number <= len(lines) else ""

    def function_at(self, line):
        return next((f.name for f in self.functions if f.first <= line <= f.last), "")

    def find_functions(self):
        at, begin = 0, 0                 # begin: behind the last thing at the outermost level
        while at < len(self.code):
            c = self.code[at]
            if c == ";":
                begin = at + 1
            elif c == "{":
                end = closing(self.code, at)
                head = self.code[begin:at]
                name = re.search(rf"({NAME})\s*\([^{{}};=]*\)\s*$", self.flat(head))
                if name:
                    first = begin + len(head) - len(head.lstrip())
                    yield Function(name[1], self.line_of(first), self.line_of(end))
                    begin = end + 1
                at = end
            at += 1

    @staticmethod
    def flat(head):
        """Without what is bracketed inside brackets, so that the last pair is the parameter list."""
        while True:
            inner = re.sub(r"(\([^()]*)\([^()]*\)", r"\1", head)
            if inner == head:
                return head
            head = inner

    def body(self, at):
        """A loop's body from `at`, behind its bracket."""
        brace = re.compile(r"\s*\{").match(self.code, at)
        return self.code[brace.end() - 1:closing(self.code, brace.end() - 1) + 1] if brace else self.code[at:self.code.index(";", at) + 1]

    def find_loops(self):
        ends_of_do = set()
        for match in re.finditer(r"\b(for|while|do)\b", self.code):
            if match[1] == "do":
                end = closing(self.code, self.code.index("{", match.end()))
                ends_of_do.add(self.code.index("while", end))
                yield Loop(self.line_of(match.start()), False)
            elif match.start() not in ends_of_do:
                bracket = self.code.index("(", match.end())
                end = closing(self.code, bracket)
                head = " ".join(self.code[bracket + 1:end].split())
                parts = head.split(";") if match[1] == "for" else ["", head, ""]
                yield Loop(self.line_of(match.start()), bounded(parts[1].strip(), parts[2].strip(), self.body(end + 1), self.code[:end]))


def conjuncts(condition):
    parts, depth, start = [], 0, 0
    for k, c in enumerate(condition):
        depth += (c == "(") - (c == ")")
        if depth == 0 and condition.startswith("&&", k):
            parts.append(condition[start:k])
            start = k + 2
    return [p.strip() for p in parts + [condition[start:]]] if "||" not in condition else []


def changes(name, text):
    """How often `name`, and no member or neighbour of that name, is written to in text."""
    word = rf"(?<![\w.>*]){re.escape(name)}(?!\w)"
    address = rf"(?:[(,=?:{{]|return) *& *{re.escape(name)}(?! *(?:->|\.|\[|\w))"
    return len(re.findall(rf"{word} *(?:\+\+|--|(?:[-+*/%&|^]|<<|>>)?=(?!=))|(?:\+\+|--){word}|{address}", text))


def paths(text):
    """What an expression reads: of a->b.c that is a, a->b and a->b.c."""
    for match in re.finditer(rf"{NAME}(?:(?:->|\.){NAME})*", text):
        yield from (match[0][:m.end()] for m in re.finditer(NAME, match[0]))


def outermost(body):
    """Without what stands in braces inside its own: that is not done every turn."""
    inner = re.compile(r"\{[^{}]*\}")
    begin, end = body.find("{") + 1, body.rfind("}")
    text = body[begin:end] if begin > 0 else body
    while inner.search(text):
        text = inner.sub("", text)
    return text


def number(text):
    found = NUMBER.match(text)
    return int(found[1], 0) if found else None


def move(name, text):
    """(direction, size) of the one step of `name` in text, 0 for a direction towards 0, or for a size that cannot be seen; None where
    there is no step, or two."""
    own, back = rf"(?<![\w.>]){re.escape(name)}", rf"{re.escape(name)}(?!\w)"
    found = [(1, 1)] * len(re.findall(rf"{own}\+\+|\+\+{back}", text)) + [(-1, 1)] * len(re.findall(rf"{own}--|--{back}", text))
    for sign, by in re.findall(rf"{own} *(\+|-|<<|>>|/)= *([^=,;]+)", text):
        size = number(by.strip()) or int(by.strip().isupper())          # a macro is a constant, and none here is 0
        found.append({"+": (1, size), "-": (-1, size), "<<": (1, 0), ">>": (0, size), "/": (0, max(size - 1, 0))}[sign])
    return found[0] if len(found) == 1 else None


def type_of(name, before):
    """Of the last declaration of a variable before a place; "" where none is found."""
    found = re.findall(rf"({TYPE}(?:\s+{TYPE})*)(?:(?!{TYPE})[^;(){{}}=])*?(?<![\w.>]){re.escape(name)}\b", before)
    return found[-1] if found else ""


def arrives(direction, size, compared, limit, kind):
    """Whether steps of this kind reach the limit: not away from it, not over it, not past the end of the type and round again."""
    value, narrow = number(limit), re.search(r"char|short|int(8|16)_t", kind)
    signed = kind != "" and not re.search(r"unsigned|uint|size_t", kind)
    largest = {"uint8_t": 255, "uint16_t": 65535}.get(kind, 127) if narrow or kind == "" else 2**31 - 1
    if re.search(r"real|wide|float|double", kind):             # it may stand still
        return False
    if size == 0 or direction == 0:
        return size > 0 and value == 0 and compared in (">", "!=")
    if direction > 0 and compared in ("<", "<="):
        if size > 1 and value is None:             # it may pass the end of its type: `k += 4` at the last three numbers
            return False
        return value <= largest - (compared == "<=") if value is not None else compared == "<" and not narrow
    if direction < 0 and compared == ">=":
        return signed or (value is not None and value >= size)
    return (direction < 0 and compared == ">" and (signed or size == 1)) or (compared == "!=" and size == 1)


def bounded(condition, step, body, before):
    for part in conjuncts(condition):
        match = COMPARES.match(part)
        if not match:
            continue
        name, compared, limit = match[2], match[4], match[5]
        inside = changes(name, body)
        walked = re.findall(rf"^ *{re.escape(name)}(?:\+\+|--);", outermost(body), re.M)
        held = not re.search(rf"{NAME}\s*\(", re.sub(r"\b(?:sizeof|R|W)\s*\(", "(", limit))
        held = held and not any(changes(n, body) or changes(n, step) for n in paths(limit))
        made = [m for m in (move(name, part), move(name, step)) if m] if not re.search(r"&&|\|\||\?", step) else []
        if inside == 1 and len(walked) == 1 and not made and "continue" not in body:
            made, inside = [move(name, walked[0])], 0
        if held and inside == 0 and len(made) == 1 and arrives(*made[0], compared, limit, type_of(name, before)):
            return True
    return False


@functools.lru_cache(None)
def of(root, path):
    full = os.path.join(root, path)
    with open(full, encoding="utf-8") as file:
        return Source(file.read())
