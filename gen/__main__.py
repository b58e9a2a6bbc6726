"""python3 gen WELL.toml [--out DIR] [--as NAME] [--print] [--convergence]

Well file -> certified C table, or one line that says why not. With --convergence no table: a report on how many elements
and modes are enough for this string.

Exit 0 written; 1 the result could not be written; 2 the well file or the command line is wrong. Nothing is left
half-written: both files are complete under other names before either takes its own.
"""
import argparse
import os
import sys

sys.dont_write_bytecode = True


class Parser(argparse.ArgumentParser):
    """Errors on one line."""

    def error(self, message):
        sys.exit(_fail(f"kelly gen: {message} (usage: {self.format_usage().split(' ', 1)[1].strip()})"))


def _fail(line, code=2):
    print(line, file=sys.stderr)
    return code


def _arguments(argv):
    root = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
    parser = Parser(prog="gen", description="Well file -> certified C table of the drill string.")
    parser.add_argument("well", metavar="WELL.toml")
    parser.add_argument("--out", metavar="DIR", help="directory of the two files (default: firmware/tables)",
                        default=os.path.join(root, "firmware", "tables"))
    parser.add_argument("--as", metavar="NAME", dest="base",
                        help="call the files NAME.c and NAME_shapes.c (default: by the key `name` of the well file)")
    parser.add_argument("--print", action="store_true", dest="show", help="print the certificate")
    parser.add_argument("--convergence", action="store_true",
                        help="write nothing; print what other numbers of elements and of modes would give (a minute or two)")
    options = parser.parse_args(argv)
    if options.base is not None and (not options.base or os.path.basename(options.base) != options.base):
        parser.error(f"--as {options.base}: expected the name of a file, without a directory")
    return options


def generate(path, base=None):
    """-> ({file name: text}, lines of the certificate, a WellError that is only to be told, or None). Raises WellError."""
    import well as well_
    well = well_.parse(_read(path))

    # numpy from here on: a bad file is told without waiting for it
    import bars
    import certify
    import emit_c
    import reduce
    import stability
    chain = bars.build(well)
    try:
        reduction = reduce.reduce(well, chain)
        stable = stability.stability(well, reduction)
        if not stability.is_safe(well, stable):
            step = next(text for key, text in well.inputs if key == "run.step_s")
            raise well_.WellError(_unsafe(stable), ("run", "step_s"), well_.Decimal(step))
        certificate = certify.certify(well, chain, reduction, stable)
    except (reduce.ReduceError, certify.CertifyError) as error:
        raise well_.WellError(str(error)) from None
    base = base or well.name
    table, shapes = emit_c.emit(well, chain, reduction, stable, certificate, os.path.basename(path))
    return {f"{base}.c": table, f"{base}_shapes.c": shapes}, certificate, well_.lift_off(well)


def _unsafe(stable):
    """What to tell the owner of a step that is too large."""
    largest = int(stable.step_max * 1e6) / 1e6          # down to a whole microsecond
    if largest == 0.0:
        return f"no step of 1 us or more is safe for RK4: the fastest rate is {stable.rate:.3g} 1/s"
    return (f"expected at most {largest:g} s, the largest step safe for RK4 (fastest rate {stable.rate:.0f} 1/s, "
            f"exceeded with probability 1e-6; largest frequency {stable.fastest:.0f} rad/s)")


def _read(path):
    import well as well_
    try:
        with open(path, "rb") as file:
            return file.read().decode("utf-8-sig")   # as some editors begin a file
    except UnicodeDecodeError as error:
        raise well_.WellError(f"expected UTF-8 text, byte {error.start} is none") from None
    except (OSError, ValueError) as error:
        raise well_.WellError(f"expected a readable file: {getattr(error, 'strerror', None) or error}") from None


def _text(path):
    """The file again, for the line numbers of a message."""
    try:
        with open(path, encoding="utf-8-sig") as file:
            return file.read()
    except (OSError, ValueError):
        return ""


def write(directory, files):
    """{name: text} -> directory, all or none: two files of different strings must not stand side by side."""
    temporary, placed = {}, []
    try:
        os.makedirs(directory, exist_ok=True)
        for name, text in files.items():
            temporary[name] = os.path.join(directory, f".{name}.{os.getpid()}")
            with open(temporary[name], "w", encoding="ascii", newline="\n") as file:
                file.write(text)
        for name in files:
            os.replace(temporary[name], os.path.join(directory, name))
            placed.append(os.path.join(directory, name))
    except BaseException:
        for path in [*temporary.values(), *placed]:
            if os.path.exists(path):
                os.remove(path)
        raise


def main(argv):
    options = _arguments(argv)
    try:
        import well as well_
        if options.convergence:
            import convergence
            convergence.report(well_.parse(_read(options.well)))
            return 0
        files, certificate, warning = generate(options.well, options.base)
    except ImportError as error:
        return _fail(f"kelly gen: {sys.executable} has no {error.name}: expected Python 3.11 or later with numpy "
                     "(Debian: /usr/bin/python3 and python3-numpy)", 1)
    except well_.WellError as error:
        return _fail(well_.message(error, options.well, _text(options.well)))
    try:
        write(options.out, files)
    except OSError as error:
        return _fail(f"kelly gen: {options.out}: cannot write: {error.strerror}", 1)
    if warning:
        print(well_.message(warning, options.well, _text(options.well)), file=sys.stderr)
    if options.show:
        print("\n".join(certificate))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
