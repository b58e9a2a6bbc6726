"""programs.py - the programs that a check runs: what make has built in this tree, or what --float and --double name, an installed one say."""
import argparse
import os

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
PROGRAM = {"float": os.path.join(ROOT, "build", "host", "kelly"), "double": os.path.join(ROOT, "build", "host-double", "kelly")}


def command_line(doc):
    """The parser of a check; its usage stands in its docstring."""
    parser = argparse.ArgumentParser(usage=doc.split("\n\n")[1].removeprefix("usage: "))
    for real in ("float", "double"):
        parser.add_argument("--" + real, default=PROGRAM[real], metavar="KELLY")
    return parser


def chosen(parser):
    """What the command line says; from here on PROGRAM is what it chose."""
    args = parser.parse_args()
    for real in ("float", "double"):
        PROGRAM[real] = os.path.abspath(getattr(args, real))
        if not os.path.exists(PROGRAM[real]):
            parser.error(f"no {PROGRAM[real]}: make all REAL={real}")
    return args
